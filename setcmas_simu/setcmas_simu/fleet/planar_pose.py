"""Planar poses: wrapping of headings, their conversion to and from quaternions, distances."""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from setcmas_simu.arrays import Floats

Pose = tuple[float, float, float]
"""x, y in m and theta in rad."""

Numbers = TypeVar('Numbers', float, Floats)


def wrap_angle(angle: ArrayLike) -> Floats:
    """Wrap angles in rad, of any shape, to (-pi, pi]."""
    # Subtracting from pi closes the interval at +pi, where a plain modulo would give -pi.
    return np.pi - np.mod(np.pi - np.asarray(angle, dtype=float), 2 * np.pi)


def quaternion_of_yaw(yaw: Numbers) -> tuple[Numbers, Numbers]:
    """Return (z, w) of the unit quaternion that turns by `yaw` rad about z; its x and y are 0."""
    half = 0.5 * yaw
    return np.sin(half), np.cos(half)


def yaw_of_quaternion(x: float | Numbers, y: float | Numbers, z: Numbers, w: Numbers) -> Numbers:
    """Return the heading in rad, in (-pi, pi], of a quaternion or of arrays of quaternions.

    The z angle of the z-y-x Euler sequence (Siciliano et al., Robotics, 2009, section 2.4.2).
    The quaternion need not have unit norm.
    """
    # numpy for single values too: math.atan2 may differ in the last bit.
    yaw: Numbers = np.arctan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)
    return yaw


def through_quaternion(poses: Floats) -> Floats:
    """Return poses (3, ...) as messages carry them: the heading passes through a quaternion.

    The result is a copy with theta in (-pi, pi].
    """
    received: Floats = poses.copy()
    z, w = quaternion_of_yaw(poses[2])
    received[2] = np.arctan2(2.0 * (w * z + 0.0), w * w - z * z)  # yaw_of_quaternion: x = y = 0
    return received


def motion_between(old: Pose, new: Pose) -> tuple[float, float]:
    """Return how far in m, and by which angle from 0 to pi rad, two poses are apart."""
    return math.dist(old[:2], new[:2]), abs(float(wrap_angle(new[2] - old[2])))
