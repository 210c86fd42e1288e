"""Projection between a camera's picture and planes above the floor, and its accuracy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from setcmas_expe.camera.camera_file import Camera, RobotTags
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError, needs

with needs('camera'):
    import cv2

CORNER_ERROR_PX = 0.15
"""Standard deviation of a detected corner in px, as measured in rendered pictures."""


class FloorProjection:
    """Maps points above the floor to pixels, and pixels back to a plane of known height."""

    def __init__(self, camera: Camera) -> None:
        """Take a calibrated camera.

        Raises:
            SetcmasError: Its pose is unknown.
        """
        if camera.pose is None:
            raise SetcmasError(
                f"camera '{camera.name}' has no pose: run setcmas camera with --calibrate floor"
            )
        self.camera = camera
        self.error = camera.pose.error
        self._rotation = np.array(camera.pose.rotation)
        self._to_camera = np.asarray(cv2.Rodrigues(self._rotation)[0], float)
        self._centre = np.array(camera.pose.position)
        self._distortion = np.array(camera.lens.distortion)

    def pixels(self, points: Floats) -> Floats:
        """Return the pixels (N, 2) of points x, y, z in m, shape (N, 3)."""
        shift = -self._to_camera @ self._centre
        found, _ = cv2.projectPoints(
            points, self._rotation, shift, self.camera.lens.matrix, self._distortion
        )
        return np.asarray(found, float).reshape(-1, 2)

    def points(self, pixels: Floats, height: float) -> Floats:
        """Return where the rays of pixels (N, 2) meet the plane of a height in m.

        Returns:
            x and y in m, shape (N, 2); NaN where the ray does not meet the plane.
        """
        rays = cv2.undistortPoints(
            np.asarray(pixels, float).reshape(-1, 1, 2), self.camera.lens.matrix, self._distortion
        ).reshape(-1, 2)
        directions = np.column_stack([rays, np.ones(len(rays))]) @ self._to_camera
        fall = directions[:, 2]
        fall = np.where(fall < 0, fall, np.nan)
        along = (height - self._centre[2]) / fall
        meets: Floats = self._centre[:2] + along[:, None] * directions[:, :2]
        return meets

    def sees(self, point: Floats) -> bool:
        """Return whether a point x, y, z in m is inside the picture."""
        if (self._to_camera @ (point - self._centre))[2] <= 0:
            return False
        pixel = self.pixels(point[None])[0]
        return bool((pixel >= 0).all() and (pixel <= np.array(self.camera.lens.size) - 1).all())


@dataclass(frozen=True)
class Accuracy:
    """Expected standard deviations of a pose: position in m, heading in rad, and the tag in px."""

    position: float
    heading: float
    pixels_per_tag: float


def expected_accuracy(
    projection: FloorProjection, tags: RobotTags, x: float, y: float
) -> Accuracy | None:
    """Return the expected accuracy of a robot at x, y in m; None where the camera sees no tag.

    The pixels of a metre are those of the direction with the fewest.
    """
    point = np.array([x, y, tags.height])
    if not projection.sees(point):
        return None
    half = tags.size / 2
    steps = np.array([[half, 0, 0], [-half, 0, 0], [0, half, 0], [0, -half, 0]])
    ends = projection.pixels(point + steps)
    jacobian = np.column_stack([ends[0] - ends[1], ends[2] - ends[3]]) / tags.size
    per_metre = float(np.linalg.svd(jacobian, compute_uv=False)[-1])
    lens = projection.camera.lens
    mean_of_corners = CORNER_ERROR_PX / 2  # four corners
    position = np.hypot(np.hypot(mean_of_corners, lens.error) / per_metre, projection.error)
    heading = CORNER_ERROR_PX / (np.sqrt(2.0) * per_metre * tags.size)
    return Accuracy(float(position), float(heading), per_metre * tags.size)
