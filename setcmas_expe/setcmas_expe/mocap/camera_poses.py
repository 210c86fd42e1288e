"""Poses of robots from pictures: tags, cameras fused without a jump, watch on the floor tags."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from setcmas_expe.mocap.camera_file import Camera, CameraFile, RobotTags
from setcmas_expe.mocap.sample import Pose
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError, needs

with needs('camera'):
    import cv2

Picture = cv2.typing.MatLike
Shot = tuple[float, Picture]
"""Time of the exposure in s since 1970, and the picture."""

OLDEST_S = 0.25
"""Age in s from which a camera's pose is not used."""

_MOST_SHIFT_M = 0.03
"""Distance in m from which a floor tag is away from its place."""
_MOST_APART_M = 0.15
"""Distance between what two cameras see from which neither is believed."""
_LONGEST_HIDDEN_S = 1.0
"""Time without any floor tag after which a camera cannot be trusted."""
_SURE_AFTER_S = 0.2
_EDGE_PX = 100.0
"""Distance from the picture's edge up to which a camera's weight falls."""
_LEAST_WEIGHT = 1e-3
_MOST_SIZE_ERROR = 0.04
_FIRST_BYTE = 0b001000_01  # of tag 0: its first row and the beginning of the second one
_MOST_SHAPE_ERROR = 0.05
"""Largest distance of a corner from its place in a square, relative to the tag's size."""
TAG_CORNERS = np.array([1 + 1j, 1 - 1j, -1 - 1j, -1 + 1j]) / 2
"""Corners of a tag with side 1 and heading 0, as x + iy, in the order of the detector."""


@dataclass(frozen=True)
class TagPose:
    """Pose of a tag: x, y in m, heading in rad, distance from the picture's edge in px."""

    x: float
    y: float
    heading: float
    edge: float


class TagDetector:
    """Finds tags and refines their corners to fractions of a pixel."""

    def __init__(self) -> None:
        parameters = cv2.aruco.DetectorParameters()
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_CONTOUR
        parameters.adaptiveThreshWinSizeMin = parameters.adaptiveThreshWinSizeMax = 31
        parameters.adaptiveThreshConstant = 12  # above the noise, whose contours cost time
        self._detector = cv2.aruco.ArucoDetector(tag_family(), parameters)

    def corners(self, picture: Picture) -> tuple[dict[int, Floats], set[int]]:
        """Return the corners (4, 2) in px of each tag, and the tags seen more than once.

        A tag that is there twice has no corners: either could be the robot.
        """
        grey = picture if picture.ndim == 2 else cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
        found, numbers, _ = self._detector.detectMarkers(grey)
        tags = [] if numbers is None else numbers.ravel().tolist()
        twice = {tag for tag in tags if tags.count(tag) > 1}
        pairs = zip(tags, found, strict=True)
        return {tag: _outer(np.float32(four)[0]) for tag, four in pairs if tag not in twice}, twice


def tag_family() -> cv2.aruco.Dictionary:
    """Return the dictionary of AprilTags 36h11; SetcmasError if glued tags would be turned."""
    family = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    if family.bytesList[0, 0, 0] != _FIRST_BYTE:
        raise SetcmasError(
            f'OpenCV {cv2.__version__} turns AprilTags by 180 degrees, so robots would drive '
            "backwards; install one up to 5.0.0: pip install 'opencv-python-headless<5.0.1'"
        )
    return family


def _outer(corners: NDArray[np.float32]) -> Floats:
    """Return the corners (4, 2) of a square from those of the centres of its outermost pixels."""
    centre: Floats = corners.mean(axis=0, dtype=float)
    return centre + (corners - centre) * (1 + 1 / math.sqrt(cv2.contourArea(corners)))


def tag_pose(camera: Camera, tags: RobotTags, corners: Floats) -> TagPose | str:
    """Return the pose of a robot's tag from its corners (4, 2) in px, or why it has none.

    The corners' rays are intersected with the plane of the tag's height; the heading is that of
    the square that fits these points best. The reason is a tag of another size, height or tilt.
    """
    points = camera.points(corners, tags.height) @ np.array([1, 1j])
    centre = points.mean()
    if not np.isfinite(centre):
        return 'the camera does not look down on it'
    # Least squares for a turned and scaled square; the sum of the corners' squares is 2.
    turned = (np.conj(TAG_CORNERS) * (points - centre)).sum() / 2
    size = abs(turned)
    if abs(size / tags.size - 1) > _MOST_SIZE_ERROR:
        expected = f'{1e3 * tags.size:.0f} mm at {tags.height:g} m above the floor'
        return f'its side measures {1e3 * size:.0f} mm; it must be {expected}'
    if np.abs(points - centre - turned * TAG_CORNERS).max() > _MOST_SHAPE_ERROR * size:
        return 'it is not a square; it must be flat, level and not covered'
    edge = float(np.minimum(corners, np.array(camera.lens.size) - 1 - corners).min())
    return TagPose(centre.real, centre.imag, float(np.angle(turned)), edge)


class CameraPoses:
    """Finds the robots in the pictures of the cameras of a file.

    Attributes:
        reasons: Why robots whose tag a camera sees have no pose, by camera.
        nb_tags: Number of tags in the last picture of each camera.
    """

    def __init__(self, file: CameraFile, nb_robots: int) -> None:
        """Find the robots 1 to N, or raise SetcmasError if a camera has no pose."""
        self.reasons: dict[str, dict[int, str]] = {}
        self.nb_tags: dict[str, int] = {}
        self._tags = file.tags
        self._nb_robots = nb_robots
        self._detector = TagDetector()
        self._cameras = {one.name: one for one in file.cameras}
        self._watches = {one.name: FloorWatch(one, file.floor_tags) for one in file.cameras}
        self._fused = FusedPoses()
        self._newest: dict[int, float] = {}

    @property
    def fault(self) -> str:
        """Why no pose may be used, in words; empty while they may."""
        return next((watch.fault for watch in self._watches.values() if watch.fault), '')

    def look(self, camera: str, t: float, picture: Picture) -> dict[int, Pose]:
        """Return x, y in m and heading in rad of the robots in a picture, grey or in colours.

        It was exposed at t in s, on a clock that all cameras share.
        """
        corners, twice = self._detector.corners(picture)
        watch = self._watches[camera]
        watch.look(t, corners)
        self.nb_tags[camera] = len(corners)
        robots = range(1, self._nb_robots + 1)
        two = 'two tags have its number; each robot needs its own'
        self.reasons[camera] = reasons = dict.fromkeys(twice.intersection(robots), two)
        found: dict[int, Pose] = {}
        if self.fault or not watch.is_right:
            return found
        for robot in sorted(corners.keys() & robots):
            pose = tag_pose(self._cameras[camera], self._tags, corners[robot])
            if isinstance(pose, str):
                reasons[robot] = pose
                continue
            self._fused.add(robot, camera, t, pose)
            fused = self._fused.pose(robot, t)
            if fused is None:
                reasons[robot] = 'two cameras see its number at different places'
            elif t >= self._newest.get(robot, -math.inf):
                self._newest[robot] = t
                found[robot] = fused
        return found


class FusedPoses:
    """Weighs the poses that cameras see, each extrapolated to the same time.

    A camera's weight falls to nearly 0 towards the edge of its picture and as its pose becomes
    old, so that a robot that leaves one camera, or a camera that stops, moves the mean gradually.
    """

    def __init__(self) -> None:
        self._seen: dict[int, dict[str, deque[tuple[float, TagPose]]]] = {}

    def add(self, robot: int, camera: str, t: float, pose: TagPose) -> None:
        """Add a pose exposed at t in s, unless it is not newer than the camera's last one."""
        seen = self._seen.setdefault(robot, {}).setdefault(camera, deque(maxlen=2))
        if not seen or t > seen[-1][0]:
            seen.append((t, pose))

    def pose(self, robot: int, t: float) -> Pose | None:
        """Return x, y in m and heading in rad of a robot at t in s.

        None if no camera sees it, or if two see it far apart: two tags with its number.
        """
        tracks = self._seen.get(robot, {}).values()
        weights = np.array([_weight(*seen[-1], t) for seen in tracks])
        if not weights.any():
            return None
        x, y, heading = np.array([_extrapolated(seen, t) for seen in tracks]).T
        places = (x + 1j * y)[weights > 0]
        if np.ptp(places.real) > _MOST_APART_M or np.ptp(places.imag) > _MOST_APART_M:
            return None
        turn = np.average(np.exp(1j * heading), weights=weights)
        x, y = np.average([x, y], axis=1, weights=weights)
        return float(x), float(y), float(np.angle(turn))


def _weight(seen_at: float, pose: TagPose, t: float) -> float:
    """Return the weight of a camera's last pose at a time t in s; 0 if it is too old."""
    freshness = max(0.0, 1 - abs(t - seen_at) / OLDEST_S)
    return freshness * max(_LEAST_WEIGHT, min(1.0, pose.edge / _EDGE_PX))


def _extrapolated(seen: deque[tuple[float, TagPose]], t: float) -> Pose:
    """Return x, y and heading at a time t in s, with the velocity between the last two poses."""
    (former_at, former), (last_at, last) = seen[0], seen[-1]
    if not 0 < last_at - former_at <= OLDEST_S:
        return last.x, last.y, last.heading
    ahead = (t - last_at) / (last_at - former_at)
    turned = math.remainder(last.heading - former.heading, math.tau)
    x, y = last.x + ahead * (last.x - former.x), last.y + ahead * (last.y - former.y)
    return x, y, math.remainder(last.heading + ahead * turned, math.tau)


class FloorWatch:
    """Compares the floor tags that a camera sees with their places.

    Attributes:
        fault: Why the camera's poses must not be used, in words; empty while they may. That it was
            moved stays until it is calibrated again.
        is_right: Whether the floor tags in the last picture were in their places.
    """

    def __init__(self, camera: Camera, floor_tags: Mapping[int, tuple[float, ...]]) -> None:
        self.fault = self._moved = ''
        self.is_right = True
        self._camera = camera
        self._places = {
            tag: place for tag, place in floor_tags.items() if camera.sees(np.array([*place, 0.0]))
        }
        self._last_seen = self._last_right = math.inf

    def look(self, t: float, corners: Mapping[int, Floats]) -> None:
        """Check the tags (4, 2) in px that the camera saw at t in s."""
        shifts = floor_shifts(self._camera, self._places, corners)
        wrong = {tag: shift for tag, shift in shifts.items() if not shift <= _MOST_SHIFT_M}
        self.is_right = not wrong
        # Before the first picture, the last good one is now.
        self._last_seen = t if shifts else min(t, self._last_seen)
        self._last_right = min(t, self._last_right) if wrong else t
        if not self._moved and wrong and t - self._last_right >= _SURE_AFTER_S:
            tag = max(wrong, key=lambda one: wrong[one])
            self._moved = (
                f'camera {self._camera.name} or floor tag {tag} was moved: the tag is '
                f'{1e3 * wrong[tag]:.0f} mm from its place; put it back, or calibrate again'
            )
        is_hidden = t - self._last_seen >= _LONGEST_HIDDEN_S
        hidden = f'camera {self._camera.name} sees no floor tag; uncover the tags, or add light'
        self.fault = self._moved or (hidden if is_hidden else '')


def floor_shifts(
    camera: Camera, places: Mapping[int, tuple[float, ...]], corners: Mapping[int, Floats]
) -> dict[int, float]:
    """Return how far in m each floor tag that a camera sees is from its place x, y in m.

    It is NaN if the camera does not look down.
    """
    return {
        tag: math.dist(camera.points(corners[tag], 0.0).mean(axis=0), places[tag])
        for tag in places.keys() & corners.keys()
    }
