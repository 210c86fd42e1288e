"""Lens from rendered views of the board, pose from floor tags."""

import numpy as np
import pytest
from camera_scene import FLOOR_TAGS, camera, cv2, pictures, seen_at
from msgspec.structs import replace

from setcmas_expe.mocap.camera_calibration import calibrated_lens, floor_pose
from setcmas_expe.mocap.camera_poses import TAG_CORNERS, TagDetector
from setcmas_expe.mocap.tag_sheets import board
from setcmas_simu.errors import SetcmasError

TRUTH = camera().lens
PX_PER_M = 3000
FIVE = FLOOR_TAGS | {505: (0.1, 0.45)}


@pytest.fixture(scope='module')
def board_picture():
    """Return a function that draws the board as a lens without distortion sees it.

    Its middle is at x, y, z in m before the camera, turned by a rotation vector.
    """
    across, down = board().getChessboardSize()
    size = np.array([across, down]) * board().getSquareLength()
    drawn = board().generateImage(tuple(round(PX_PER_M * side) for side in size))
    texture = np.where(drawn > 0, 220, 30).astype(np.uint8)
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])

    def picture(x, y, z, turn):
        places = np.column_stack([(corners - 0.5) * size, np.zeros(4)])
        seen, _ = cv2.projectPoints(places, np.array(turn, float), (x, y, z), TRUTH.matrix, None)
        drawn = np.float32(corners * texture.shape[::-1] - 0.5)
        # Three times finer than the pixels, whose centres have whole coordinates.
        warp = cv2.getPerspectiveTransform(drawn, np.float32(3 * seen.reshape(4, 2) + 1))
        fine = cv2.warpPerspective(texture, warp, np.array(TRUTH.size) * 3, borderValue=120)
        return cv2.resize(fine, TRUTH.size, interpolation=cv2.INTER_AREA)

    return picture


@pytest.mark.nightly
def test_a_lens_is_calibrated_from_the_views_that_are_asked_for(board_picture):
    tilts = [(0.5, 0, 0), (0, 0.5, 0), (-0.5, 0, 0), (0, -0.5, 0), (0, 0, 0)]
    places = [(x, y) for x in (-0.28, 0.0, 0.28) for y in (-0.13, 0.02, 0.15)]
    middle, shown = board_picture(0, 0, 0.6, (0, 0, 0)), []
    shots = [middle, middle, np.full_like(middle, 100)]  # nothing new, and no board
    with pytest.raises(SetcmasError, match='in 1 places: hold the board at the left'):
        calibrated_lens(enumerate(shots), shown.append)
    assert len(shown) == 1
    assert shown[0].startswith('view 1; next: hold the board at the left of the picture')
    for number, (x, y) in enumerate(places * 2):
        z = 0.6 if number < len(places) else 0.75
        shots.append(board_picture(x, y, z, tilts[number % 5]))

    lens = calibrated_lens(enumerate(shots), shown.append)
    assert shown[-1].endswith('next: done')
    assert lens.error < 0.2
    assert lens.size == TRUTH.size
    assert lens.focal == pytest.approx(TRUTH.focal, rel=0.01)
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
