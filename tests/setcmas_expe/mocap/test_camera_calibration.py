"""Lens from rendered views of the board, pose from floor tags."""

import numpy as np
import pytest
from camera_scene import DISTORTION, FLOOR_TAGS, camera, cv2, pictures, seen_at
from msgspec.structs import replace

from setcmas_expe.mocap.camera_calibration import LensViews, floor_pose
from setcmas_expe.mocap.camera_poses import TAG_CORNERS, TagDetector
from setcmas_expe.mocap.tag_sheets import board
from setcmas_simu.errors import SetcmasError

TRUTH = camera().lens
PX_PER_M = 3000
FIVE = FLOOR_TAGS | {505: (0.1, 0.45)}


class BoardPictures:
    """Renders the board as the camera would see it at a place and a tilt."""

    def __init__(self):
        # Three times finer than the pixels, whose centres have whole coordinates.
        across, down = ((np.arange(3 * side) - 1) / 3 for side in TRUTH.size)
        grid = np.stack(np.meshgrid(across, down), axis=-1)
        pixels = grid.reshape(-1, 1, 2).astype(np.float32)
        rays = cv2.undistortPoints(pixels, TRUTH.matrix, np.array(DISTORTION)).reshape(-1, 2)
        self.rays = np.column_stack([rays, np.ones(len(rays))])
        across, down = board().getChessboardSize()
        self.size = np.array([across, down]) * board().getSquareLength()
        picture = board().generateImage(tuple(round(PX_PER_M * side) for side in self.size))
        self.texture = np.where(picture > 0, 220, 30).astype(np.uint8)
        self.rng = np.random.default_rng(1)

    def picture(self, x, y, z, turn):
        """Return a picture of the board with its middle at x, y, z in m before the camera."""
        rotation = cv2.Rodrigues(np.array(turn, float))[0]
        normal, middle = rotation[:, 2], np.array([x, y, z])
        along = (normal @ middle) / (self.rays @ normal)
        places = (along[:, None] * self.rays - middle) @ rotation[:, :2] + self.size / 2
        at = (PX_PER_M * places - 0.5).astype(np.float32)
        at = at.reshape(3 * TRUTH.size[1], 3 * TRUTH.size[0], 2)
        seen = cv2.remap(self.texture, at, None, cv2.INTER_LINEAR, borderValue=120)
        seen = cv2.resize(seen, TRUTH.size, interpolation=cv2.INTER_AREA)
        return np.clip(seen + self.rng.normal(0, 3, seen.shape), 0, 255).astype(np.uint8)


@pytest.fixture(scope='module')
def board_pictures():
    return BoardPictures()


@pytest.mark.nightly
def test_a_lens_is_calibrated_from_the_views_that_are_asked_for(board_pictures):
    views = LensViews()
    middle = board_pictures.picture(0, 0, 0.6, (0, 0, 0))
    assert views.add(middle)
    assert not views.add(middle)  # nothing new
    assert not views.add(np.full_like(middle, 100))
    assert 'hold the board at the left of the picture' in views.missing()
    with pytest.raises(SetcmasError, match='in 1 places: hold the board at the left'):
        views.lens()

    tilts = [(0.5, 0, 0), (0, 0.5, 0), (-0.5, 0, 0), (0, -0.5, 0), (0, 0, 0)]
    places = [(x, y) for x in (-0.28, 0.0, 0.28) for y in (-0.13, 0.02, 0.15)]
    for number, (x, y) in enumerate(places * 2):
        z = 0.6 if number < len(places) else 0.75
        views.add(board_pictures.picture(x, y, z, tilts[number % 5]))

    assert views.missing() == []
    lens = views.lens()
    assert lens.error < 0.2
    assert lens.size == TRUTH.size
    assert lens.focal == pytest.approx(TRUTH.focal, rel=0.005)
    assert lens.centre == pytest.approx(TRUTH.centre, abs=5.0)


def test_a_camera_finds_its_pose_from_floor_tags():
    truth = camera()
    corners, _ = TagDetector().corners(pictures()[0])
    found = floor_pose(replace(truth, pose=None), FLOOR_TAGS, corners)

    assert found.position == pytest.approx(truth.pose.position, abs=0.01)
    assert found.rotation == pytest.approx(truth.pose.rotation, abs=0.01)
    assert found.error < 0.002


def floor_corners(places):
    """Return the corners in px of floor tags with a side of 120 mm."""
    corners = 0.12 * np.column_stack([TAG_CORNERS.real, TAG_CORNERS.imag, np.zeros(4)])
    return {
        tag: seen_at(camera(), corners + np.array([*place, 0.0])) for tag, place in places.items()
    }


def test_floor_tags_in_a_wrong_place_or_too_few_are_named():
    wrong = FIVE | {502: (0.9, -0.5)}

    with pytest.raises(SetcmasError, match='do not fit the picture, that of 502 least, by'):
        floor_pose(camera(), wrong, floor_corners(FIVE))
    with pytest.raises(SetcmasError, match='501, 502, 503, 504 do not fit the picture'):
        floor_pose(camera(), {t: wrong[t] for t in FLOOR_TAGS}, floor_corners(FLOOR_TAGS))
    with pytest.raises(SetcmasError, match="camera 'left' sees 3 of the floor tags 501, 502, 503"):
        floor_pose(camera(), {t: wrong[t] for t in (501, 502, 503)}, floor_corners(FLOOR_TAGS))
