"""Saturation of velocities; dead band for slow ones."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from setcmas_simu.arrays import Floats
from setcmas_simu.robots.model import SLOW


def saturate(velocities: ArrayLike, vnom: float) -> Floats:
    """Scale velocities down to a largest speed, keeping their directions.

    Args:
        velocities: Rows vx, vy in m/s, shape (2,) or (2, N).
        vnom: Largest speed in m/s; inf is no limit.

    Returns:
        The saturated velocities, same shape.
    """
    wanted: Floats = np.asarray(velocities, dtype=float)
    if vnom == math.inf:
        return wanted
    speeds = np.hypot(wanted[0], wanted[1])
    scaled: Floats = wanted * (vnom / np.maximum(speeds, vnom))
    return scaled


def dead_band(vx: float, vy: float, slow: float = SLOW) -> tuple[float, float]:
    """Return the velocity (m/s), or (0, 0) where its norm is below `slow` m/s."""
    return (0.0, 0.0) if vx * vx + vy * vy < slow * slow else (vx, vy)
