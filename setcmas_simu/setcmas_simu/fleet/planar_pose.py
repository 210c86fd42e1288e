"""Headings of planar poses: wrapping, and conversion from and to quaternions."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from setcmas_simu.arrays import Floats


def wrap_angle(angle: ArrayLike) -> Floats:
    """Wrap angles to (-pi, pi].

    Args:
        angle: Angles in rad, any shape.

    Returns:
        Equivalent angles in rad, the same shape.
    """
    # Subtracting from pi closes the interval at +pi, where a plain modulo would give -pi.
    return np.pi - np.mod(np.pi - np.asarray(angle, dtype=float), 2 * np.pi)


def quaternion_of_yaw(yaw: float) -> tuple[float, float]:
    """Return (z, w) of the unit quaternion that turns by `yaw` rad about z; x and y are 0."""
    return math.sin(0.5 * yaw), math.cos(0.5 * yaw)


def yaw_of_quaternion(x: float, y: float, z: float, w: float) -> float:
    """Return the heading in rad, in (-pi, pi], of a quaternion.

    The z angle of the z-y-x Euler sequence (Siciliano et al., Robotics, 2009, section 2.4.2).
    The quaternion need not have unit norm.
    """
    return math.atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)
