"""Tags in a picture: detection of AprilTags 36h11, and the pose of a robot from its tag."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from setcmas_expe.camera.camera_file import RobotTags
from setcmas_expe.camera.floor_projection import FloorProjection
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import needs

with needs('camera'):
    import cv2

Picture = NDArray[np.uint8]

Shot = tuple[float, Picture]
"""Time of the exposure in s since 1970, and the picture."""

MODULES = 8
"""Squares across the black square of a tag of the family 36h11."""
MARGIN = 1
"""White squares around the black square."""
MOST_SIZE_ERROR = 0.04
"""Largest relative difference between the measured and the given size of a tag."""
_MOST_SHAPE_ERROR = 0.05
"""Largest distance of a corner from its place in a square, relative to the tag's size."""

_CORNERS = np.array([1 + 1j, 1 - 1j, -1 - 1j, -1 + 1j]) / 2
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

        Args:
            picture: Grey, shape (height, width), or with three colours.
        """
        grey = picture if picture.ndim == 2 else cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
        found, numbers, _ = self._detector.detectMarkers(grey)
        tags = [] if numbers is None else [int(number) for number in numbers.ravel()]
        twice = {tag for tag in tags if tags.count(tag) > 1}
        pairs = zip(tags, found, strict=True)
        return {
            tag: _outer(c.reshape(4, 2).astype(float)) for tag, c in pairs if tag not in twice
        }, twice


def _outer(corners: Floats) -> Floats:
    """Return the corners (4, 2) of a square from those of the centres of its outermost pixels."""
    centre: Floats = corners.mean(axis=0)
    side = math.sqrt(cv2.contourArea(corners.astype(np.float32)))
    return centre + (corners - centre) * (1 + 1 / side)


def tag_family() -> cv2.aruco.Dictionary:
    """Return the dictionary of AprilTags 36h11."""
    return cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)


def tag_pose(projection: FloorProjection, tags: RobotTags, corners: Floats) -> TagPose | str:
    """Return the pose of a robot's tag, or the reason why it has none.

    The corners' rays are intersected with the plane of the tag's height; the heading is that of
    the square that fits these points best. The reason is a tag of another size, height or tilt.

    Args:
        projection: The camera.
        tags: Size and height of the tag.
        corners: Corners in px, shape (4, 2), as detected.
    """
    points = projection.points(corners, tags.height) @ np.array([1, 1j])
    centre = points.mean()
    if not np.isfinite(centre):
        return 'the camera does not look down on it'
    # Least squares for a turned and scaled square; the sum of the corners' squares is 2.
    turned = (np.conj(_CORNERS) * (points - centre)).sum() / 2
    size = abs(turned)
    if abs(size / tags.size - 1) > MOST_SIZE_ERROR:
        expected = f'{1e3 * tags.size:.0f} mm at {tags.height:g} m above the floor'
        return f'its side measures {1e3 * size:.0f} mm; it must be {expected}'
    if np.abs(points - centre - turned * _CORNERS).max() > _MOST_SHAPE_ERROR * size:
        return 'it is not a square; it must be flat, level and not covered'
    last = np.array(projection.camera.lens.size) - 1
    edge = float(np.minimum(corners, last - corners).min())
    return TagPose(centre.real, centre.imag, float(np.angle(turned)), edge)


def tag_poses(
    projection: FloorProjection, tags: RobotTags, corners: Mapping[int, Floats], nb_robots: int
) -> tuple[dict[int, TagPose], dict[int, str]]:
    """Return the poses of the robots 1 to N in a picture, and the reasons of those without."""
    found = {i: tag_pose(projection, tags, corners[i]) for i in corners if 1 <= i <= nb_robots}
    poses = {robot: pose for robot, pose in found.items() if isinstance(pose, TagPose)}
    return poses, {robot: text for robot, text in found.items() if isinstance(text, str)}
