"""Poses of robots from pictures: their tags, and a watch on the tags on the floor."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from setcmas_expe.mocap.camera_file import Camera, CameraFile, RobotTags
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError, needs
from setcmas_simu.fleet.planar_pose import Pose

with needs('camera'):
    import cv2

Picture = cv2.typing.MatLike
Shot = tuple[float, Picture]
"""Time of the exposure in s since 1970, and the picture."""

LOST_AFTER_S = 0.5
"""If a camera has not seen a robot for this time in s, another one may give its poses."""

_MOST_SHIFT_M = 0.03
"""Distance in m from which a floor tag is away from its place."""
_LONGEST_HIDDEN_S = 1.0
"""Time without any floor tag after which a camera cannot be trusted."""
_SURE_AFTER_S = 0.2
_MOST_SIZE_ERROR = 0.04
_FIRST_BYTE = 0b001000_01  # of tag 0: its first row and the beginning of the second one
_MOST_SHAPE_ERROR = 0.05
"""Largest distance of a corner from its place in a square, relative to the tag's size."""
TAG_CORNERS = np.array([1 + 1j, 1 - 1j, -1 - 1j, -1 + 1j]) / 2
"""Corners of a tag with side 1 and heading 0, as x + iy, in the order of the detector."""


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


def tag_pose(camera: Camera, tags: RobotTags, corners: Floats) -> Pose | str:
    """Return x, y, heading of a robot's tag from its corners (4, 2) in px, or why it has none.

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
    return float(centre.real), float(centre.imag), float(np.angle(turned))


class CameraPoses:
    """Finds the robots in the pictures of the cameras of a file.

    One camera gives a robot's poses until the robot leaves its picture.

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
        for one in file.cameras:
            _ = one.placed  # raises an error that says how to calibrate
        self._watches = {one.name: FloorWatch(one, file.floor_tags) for one in file.cameras}
        self._seen: dict[int, tuple[str, float]] = {}  # by which camera, and when

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
            seen_by, seen_at = self._seen.get(robot, (camera, t))
            if seen_by != camera and t - seen_at < LOST_AFTER_S:
                continue
            pose = tag_pose(self._cameras[camera], self._tags, corners[robot])
            if isinstance(pose, str):
                reasons[robot] = pose
            else:
                self._seen[robot] = camera, t
                found[robot] = pose
        return found


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
        self._places = floor_tags
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
