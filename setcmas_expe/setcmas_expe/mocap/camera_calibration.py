"""Calibration: a camera's lens from views of a board, its pose from tags on the floor."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from itertools import islice

import numpy as np
from msgspec.structs import replace

from setcmas_expe.mocap.camera_file import Camera, CameraFile, CameraPose, Lens, Place
from setcmas_expe.mocap.camera_poses import Shot, TagDetector, floor_shifts
from setcmas_expe.mocap.picture_sources import Size, pictures
from setcmas_expe.mocap.tag_sheets import board
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError, needs

with needs('camera'):
    import cv2

_NB_VIEWS = 15
_FEWEST_CORNERS = 8
_MOST_LENS_ERROR_PX = 1.5
_TILTED = 0.08
"""Relative change of scale across the board from which a view counts as tilted."""
_MOVED_PX = 30.0
_SIDE = 0.35
"""Width of the parts of a picture in which the board must be seen, relative to it."""
_MOST_MISFIT_M = 0.02
"""Largest distance of a floor tag from the place that the other tags imply."""
_NB_PICTURES = 30


def calibrated_lens(shots: Iterable[Shot], show: Callable[[str], None]) -> Lens:
    """Return a lens from views of the ChArUco board; show what to do next after each new view.

    The lens is that of Z. Zhang, A flexible new technique for camera calibration, IEEE Trans.
    Pattern Anal. Mach. Intell. 22(11), 2000, with the distortion of OpenCV.

    Raises:
        SetcmasError: The pictures ended before all views were seen, or the lens does not fit them.
    """
    charuco, size = board(), (0, 0)
    detector = cv2.aruco.CharucoDetector(charuco)
    points: list[Floats] = []
    pixels: list[Floats] = []
    wanted = _missing(points, pixels, size)
    for _, picture in shots:
        size = picture.shape[1], picture.shape[0]
        corners, numbers, _, _ = detector.detectBoard(picture)
        if numbers is None or len(numbers) < _FEWEST_CORNERS:
            continue
        places, seen = charuco.matchImagePoints(corners, numbers)  # type: ignore[call-overload]
        middles = [seen.mean(axis=0) - old.mean(axis=0) for old in pixels]
        if any(np.linalg.norm(moved) < _MOVED_PX for moved in middles):
            continue
        points.append(places)
        pixels.append(seen)
        wanted = _missing(points, pixels, size)
        show(f'view {len(pixels)}; next: {"; ".join(wanted) or "done"}')
        if not wanted:
            return _fitted_lens(points, pixels, size)
    raise SetcmasError(f'the board was seen in {len(pixels)} places: {"; ".join(wanted)}')


def _missing(points: list[Floats], pixels: list[Floats], size: Size) -> list[str]:
    """Return what further views must show, in words; empty if the lens can be calibrated."""
    wanted = []
    if pixels:
        x, y = (np.concatenate(pixels).reshape(-1, 2) / size).T
        parts = {'left': x < _SIDE, 'right': 1 - x < _SIDE}
        parts |= {'top': y < _SIDE, 'bottom': 1 - y < _SIDE}
        for name, inside in parts.items():
            if inside.sum() < 2 * _FEWEST_CORNERS:
                wanted.append(f'hold the board at the {name} of the picture')
        tilts = np.array(list(map(_tilt, points, pixels))) > _TILTED
        ways = zip(('left or right', 'forward or back'), tilts.sum(axis=0), strict=True)
        wanted += [f'tilt it {way}' for way, count in ways if count < 2]
    if len(pixels) < _NB_VIEWS:
        wanted.append(f'{_NB_VIEWS - len(pixels)} more views')
    return wanted


def _tilt(points: Floats, pixels: Floats) -> Floats:
    """Return by how much the scale changes across and down a board, relative to the middle."""
    points = points.reshape(-1, 3)[:, :2]
    turn, _ = cv2.findHomography(points, pixels)
    change: Floats = np.abs(turn[2, :2]) * np.ptp(points, axis=0)
    return change


def _fitted_lens(points: list[Floats], pixels: list[Floats], size: Size) -> Lens:
    flags = cv2.CALIB_FIX_K3
    error, matrix, distortion, _, _ = cv2.calibrateCamera(
        points, pixels, size, None, None, flags=flags
    )
    if error > _MOST_LENS_ERROR_PX:
        raise SetcmasError(
            f'the lens fits with {error:.1f} px; {_MOST_LENS_ERROR_PX:g} px is the most: '
            'keep the board flat and still, with more light'
        )
    (fx, _, cx), (_, fy, cy), _ = matrix.tolist()
    factors = tuple(np.ravel(distortion)[:5].tolist())
    return Lens(size, (fx, fy), (cx, cy), factors, float(error))


def calibrated_floor(file: CameraFile) -> CameraFile:
    """Return a camera file with the pose of each camera, from pictures of the floor tags.

    Raises:
        SetcmasError: Tags are missing, or are not at the places in the file.
    """
    places = file.floor_tags
    if len(places) < 4:
        raise SetcmasError(
            f'the file has {len(places)} floor tags; write the centres of four or more, such as '
            'floor_tags: {501: [0.0, 0.0], 502: [4.0, 0.0]}'
        )
    cameras = [replace(one, pose=floor_pose(one, places, _seen_tags(one))) for one in file.cameras]
    return replace(file, cameras=tuple(cameras))


def _seen_tags(camera: Camera) -> dict[int, Floats]:
    """Return the corners (4, 2) in px of the tags in several pictures, their medians."""
    seen = defaultdict(list)
    for _, picture in islice(pictures(camera.source, camera.lens.size), _NB_PICTURES):
        for tag, corners in TagDetector().corners(picture)[0].items():
            seen[tag].append(corners)
    return {tag: np.median(corners, axis=0) for tag, corners in seen.items()}


def floor_pose(
    camera: Camera, places: Mapping[int, Place], corners: Mapping[int, Floats]
) -> CameraPose:
    """Return the pose from which a camera sees the `corners` (4, 2) in px of tags in their places.

    Raises:
        SetcmasError: Fewer than four tags are seen, or they do not fit together.
    """
    seen = sorted(places.keys() & corners.keys())
    if len(seen) < 4:
        raise SetcmasError(
            f"camera '{camera.name}' sees {len(seen)} of the floor tags "
            f'{", ".join(map(str, sorted(places)))}; it needs four'
        )
    points = np.array([[*places[tag], 0.0] for tag in seen])
    centres = np.array([corners[tag].mean(axis=0) for tag in seen])
    lens = camera.lens.matrix, np.array(camera.lens.distortion)
    _, turn, shift = cv2.solvePnP(points, centres, *lens, flags=cv2.SOLVEPNP_IPPE)
    turn, shift = cv2.solvePnPRefineLM(points, centres, *lens, turn, shift)
    position = -np.asarray(cv2.Rodrigues(turn)[0]).T @ shift.ravel()
    if not position[2] > 0:
        raise SetcmasError(
            f"camera '{camera.name}' would be below the floor: tags are numbered "
            'counter-clockwise as seen from above'
        )
    pose = CameraPose(tuple(position.tolist()), tuple(turn.ravel().tolist()), 0.0)
    misfits = floor_shifts(replace(camera, pose=pose), places, corners)
    worst = max(seen, key=lambda tag: misfits[tag])
    if misfits[worst] > _MOST_MISFIT_M:
        raise SetcmasError(
            f'the places of floor tags {", ".join(map(str, seen))} do not fit the picture, that '
            f'of {worst} least, by {1e3 * misfits[worst]:.0f} mm; measure them again'
        )
    # Six numbers were fitted to two for each tag.
    spread = np.linalg.norm(list(misfits.values())) / np.sqrt(max(1, 2 * len(seen) - 6))
    return replace(pose, error=round(float(spread), 5))
