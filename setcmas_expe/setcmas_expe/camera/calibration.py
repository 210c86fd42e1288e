"""Calibration: a camera's lens from views of a board, its pose from tags on the floor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from setcmas_expe.camera.camera_file import Camera, CameraPose, Lens
from setcmas_expe.camera.floor_projection import FloorProjection
from setcmas_expe.camera.tag_detection import Picture
from setcmas_expe.camera.tag_sheets import board
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError, needs

with needs('camera'):
    import cv2

NB_VIEWS = 15
"""Views of the board that a lens needs, at least."""
MOST_MISFIT_M = 0.02
"""Largest distance in m of a floor tag, or of a distance, from what the others say."""

_FEWEST_CORNERS = 8
_MOST_LENS_ERROR_PX = 1.5
_TILTED = 0.08
"""Relative difference of opposite sides from which a view counts as tilted."""
_MOVED_PX = 30.0
_PARTS = {
    'left': (0.0, 0.35, 0, 1),
    'right': (0.65, 1.0, 0, 1),
    'top': (0, 1, 0.0, 0.35),
    'bottom': (0, 1, 0.65, 1.0),
}
_STEPS = 50


class LensViews:
    """Collects views of the ChArUco board, and calibrates the lens with them.

    The lens is that of Z. Zhang, A flexible new technique for camera calibration, IEEE Trans.
    Pattern Anal. Mach. Intell. 22(11), 2000, with the distortion of OpenCV.
    """

    def __init__(self) -> None:
        self._board = board()
        self._detector = cv2.aruco.CharucoDetector(self._board)
        self._size: tuple[int, int] | None = None
        self._pixels: list[Floats] = []
        self._points: list[Floats] = []
        self._tilts = {'left or right': 0, 'forward or back': 0}

    def __len__(self) -> int:
        return len(self._pixels)

    def add(self, picture: Picture) -> bool:
        """Add a picture; return whether it shows the board in a place where it was not yet."""
        height, width = picture.shape[:2]
        if self._size not in (None, (width, height)):
            raise SetcmasError(f'a picture has {width} x {height} px; others had {self._size}')
        self._size = width, height
        corners, numbers, _, _ = self._detector.detectBoard(picture)
        if numbers is None or len(numbers) < _FEWEST_CORNERS:
            return False
        points, pixels = self._board.matchImagePoints(corners, numbers)  # type: ignore[call-overload]
        points, pixels = points.reshape(-1, 3), pixels.reshape(-1, 2)
        if any(_is_near(pixels.mean(0), old.mean(0)) for old in self._pixels):
            return False
        self._points.append(points)
        self._pixels.append(pixels)
        across, down = _perspective(points, pixels)
        self._tilts['left or right'] += abs(across) > _TILTED
        self._tilts['forward or back'] += abs(down) > _TILTED
        return True

    def missing(self) -> list[str]:
        """Return what further views must show, in words; empty if the lens can be calibrated."""
        wanted = []
        if self._size and self._pixels:
            seen = np.concatenate(self._pixels) / self._size
            for name, (left, right, top, bottom) in _PARTS.items():
                inside = (seen >= (left, top)).all(1) & (seen <= (right, bottom)).all(1)
                if inside.sum() < 2 * _FEWEST_CORNERS:
                    wanted.append(f'hold the board at the {name} of the picture')
            wanted += [f'tilt it {way}' for way, count in self._tilts.items() if count < 2]
        if len(self) < NB_VIEWS:
            wanted.append(f'{NB_VIEWS - len(self)} more views')
        return wanted

    def lens(self) -> Lens:
        """Return the lens with its reprojection error.

        Raises:
            SetcmasError: Views are missing, or the error is too large.
        """
        if (wanted := self.missing()) or self._size is None:
            raise SetcmasError(f'the board was seen in {len(self)} places: {"; ".join(wanted)}')
        points = [one.astype(np.float32) for one in self._points]
        pixels = [one.astype(np.float32) for one in self._pixels]
        error, matrix, distortion, _, _ = cv2.calibrateCamera(
            points, pixels, self._size, None, None, flags=cv2.CALIB_FIX_K3
        )
        if error > _MOST_LENS_ERROR_PX:
            raise SetcmasError(
                f'the lens fits with {error:.1f} px; {_MOST_LENS_ERROR_PX:g} px is the most: '
                'keep the board flat and still, with more light'
            )
        k = [float(one) for one in np.ravel(distortion)[:5]]
        return Lens(
            self._size,
            (float(matrix[0, 0]), float(matrix[1, 1])),
            (float(matrix[0, 2]), float(matrix[1, 2])),
            tuple(k),
            float(error),
        )


def floor_pose(
    camera: Camera, places: Mapping[int, Sequence[float]], corners: Mapping[int, Floats]
) -> CameraPose:
    """Return the pose from which a camera sees floor tags in their places.

    Args:
        camera: The camera, with its lens.
        places: Centre x, y in m of each floor tag.
        corners: Corners (4, 2) in px of the tags that it sees.

    Raises:
        SetcmasError: Fewer than four tags are seen, or they do not fit together.
    """
    seen = sorted(places.keys() & corners.keys())
    if len(seen) < 4:
        raise SetcmasError(
            f"camera '{camera.name}' sees {len(seen)} of the floor tags "
            f'{", ".join(map(str, sorted(places)))}; it needs four'
        )
    pose, misfits = _fitted(camera, places, corners, seen)
    worst = max(seen, key=lambda tag: misfits[tag])
    if misfits[worst] <= MOST_MISFIT_M:
        return pose
    if len(seen) > 4:
        without = {
            tag: _fitted(camera, places, corners, [t for t in seen if t != tag])[1] for tag in seen
        }
        culprit = min(seen, key=lambda tag: max(without[tag].values()))
        if max(without[culprit].values()) <= MOST_MISFIT_M:
            raise SetcmasError(
                f'floor tag {culprit} is not where the file says, by the others about '
                f'{1e3 * misfits[culprit]:.0f} mm away; measure it again'
            )
    raise SetcmasError(
        f'the places of floor tags {", ".join(map(str, seen))} do not fit the picture, by '
        f'{1e3 * misfits[worst]:.0f} mm; measure them again'
    )


def _fitted(
    camera: Camera,
    places: Mapping[int, Sequence[float]],
    corners: Mapping[int, Floats],
    tags: Sequence[int],
) -> tuple[CameraPose, dict[int, float]]:
    """Return a pose, and the distance in m of each tag from its place."""
    points = np.array([[*places[tag], 0.0] for tag in tags])
    centres = np.array([corners[tag].mean(axis=0) for tag in tags])
    distortion = np.array(camera.lens.distortion)
    _, turns, shifts, _ = cv2.solvePnPGeneric(
        points, centres, camera.lens.matrix, distortion, flags=cv2.SOLVEPNP_IPPE
    )
    best: tuple[CameraPose, dict[int, float]] | None = None
    for turn, shift in zip(turns, shifts, strict=True):
        turn, shift = cv2.solvePnPRefineLM(
            points, centres, camera.lens.matrix, distortion, turn, shift
        )
        position = -np.asarray(cv2.Rodrigues(turn)[0]).T @ shift.ravel()
        if position[2] <= 0:
            continue
        pose = CameraPose(tuple(map(float, position)), tuple(map(float, turn.ravel())), 0.0)
        found = FloorProjection(replace(camera, pose=pose)).points(centres, 0.0)
        misfits = np.hypot(*(found - points[:, :2]).T)
        if np.isfinite(misfits).all() and (not best or misfits.max() < max(best[1].values())):
            # Six numbers were fitted to two for each tag.
            spread = float(np.sqrt((misfits**2).sum() / max(1, 2 * len(tags) - 6)))
            pose = CameraPose(pose.position, pose.rotation, round(spread, 5))
            best = pose, dict(zip(tags, misfits.tolist(), strict=True))
    if best is None:
        raise SetcmasError(
            f"camera '{camera.name}' would be below the floor: tags are numbered "
            'counter-clockwise as seen from above'
        )
    return best


def places_from_distances(
    distances: Mapping[tuple[int, int], float],
) -> dict[int, tuple[float, ...]]:
    """Return the centres of tags in m from distances between them.

    The first tag is at 0, 0, the second on the x axis, and the third has y above 0.

    Raises:
        SetcmasError: Distances are missing, or contradict each other.
    """
    tags = sorted({tag for pair in distances for tag in pair})
    known = {frozenset(pair): length for pair, length in distances.items()}
    pairs = (
        [(tags[0], tags[1])]
        + [pair for tag in tags[2:] for pair in ((tags[0], tag), (tags[1], tag))]
        if len(tags) > 1
        else []
    )
    if missing := [pair for pair in pairs if frozenset(pair) not in known]:
        a, b = missing[0]
        raise SetcmasError(
            f'the distance {a}-{b} is missing; each tag needs those to the first two'
        )
    if len(tags) < 4:
        raise SetcmasError(f'distances name {len(tags)} floor tags; a camera needs four')
    base = known[frozenset(tags[:2])]
    places = {tags[0]: np.zeros(2), tags[1]: np.array([base, 0.0])}
    for tag in tags[2:]:
        to_first, to_second = (known[frozenset((one, tag))] for one in tags[:2])
        x = (base**2 + to_first**2 - to_second**2) / (2 * base)
        y = np.sqrt(max(0.0, to_first**2 - x**2))
        # Above the x axis like the third, unless a distance to an earlier tag says otherwise.
        others = [one for one in places if frozenset((one, tag)) in known]
        signs = (1.0, -1.0) if len(places) > 2 else (1.0,)
        places[tag] = min(
            (np.array([x, sign * y]) for sign in signs),
            key=lambda at: sum(
                abs(np.hypot(*(at - places[one])) - known[frozenset((one, tag))]) for one in others
            ),
        )
    ends = [(a, b) for a, b in combinations(tags, 2) if frozenset((a, b)) in known]
    lengths = np.array([known[frozenset(pair)] for pair in ends])
    indices = np.array([[tags.index(a), tags.index(b)] for a, b in ends])
    points, errors = _least_squares(np.array([places[tag] for tag in tags]), indices, lengths)
    worst = int(np.abs(errors).argmax())
    if abs(errors[worst]) > MOST_MISFIT_M / 2:
        a, b = ends[worst]
        raise SetcmasError(
            f'the distances contradict each other, {a}-{b} most, by '
            f'{1e3 * abs(errors[worst]):.0f} mm; measure them again'
        )
    return {tag: (float(x), float(y)) for tag, (x, y) in zip(tags, points, strict=True)}


def _least_squares(
    points: Floats, ends: NDArray[np.int64], lengths: Floats
) -> tuple[Floats, Floats]:
    """Return points (N, 2) moved to fit lengths (M,) between pairs of them, and the errors (M,).

    The first stays at 0, 0, the second on the x axis (Gauss-Newton).
    """
    rows = np.arange(len(ends))
    for _ in range(_STEPS):
        along = points[ends[:, 0]] - points[ends[:, 1]]
        far = np.hypot(*along.T)
        slopes = np.zeros((len(ends), *points.shape))
        slopes[rows, ends[:, 0]] = along / far[:, None]
        slopes[rows, ends[:, 1]] = -along / far[:, None]
        step, *_ = np.linalg.lstsq(slopes.reshape(len(ends), -1), lengths - far, rcond=None)
        points = points + step.reshape(points.shape)
    moved = (points - points[0]) @ np.array([1, 1j])
    moved = moved * np.exp(-1j * np.angle(moved[1]))
    errors = np.abs(moved[ends[:, 0]] - moved[ends[:, 1]]) - lengths
    return np.column_stack([moved.real, moved.imag]), errors


def _perspective(points: Floats, pixels: Floats) -> tuple[float, float]:
    """Return by how much the board's sides differ in the picture: left to right, top to bottom."""
    turn, _ = cv2.findHomography(points[:, :2], pixels)
    low, high = points[:, :2].min(0), points[:, :2].max(0)
    box = np.array([low, [high[0], low[1]], high, [low[0], high[1]]])
    a, b, c, d = cv2.perspectiveTransform(box[None], turn)[0]
    left, right, top, bottom = (
        float(np.hypot(*(p - q))) for p, q in ((a, d), (b, c), (a, b), (d, c))
    )
    return right / left - 1, bottom / top - 1


def _is_near(a: Floats, b: Floats) -> bool:
    return float(np.hypot(*(a - b))) < _MOVED_PX
