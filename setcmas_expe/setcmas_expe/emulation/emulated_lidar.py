"""Lidar of an emulated TurtleBot3, which sees people and other robots as discs."""

from __future__ import annotations

import math

import numpy as np

from setcmas_simu.arrays import Floats

LIDAR_RATE_HZ = 5.0
"""Turns of an LDS-01 in a second."""

NB_POINTS = 360
"""Points that it measures in a turn, the first straight ahead, then to the left."""

_ANGLES = np.linspace(0.0, 2.0 * math.pi, NB_POINTS, endpoint=False)


def ranges(pose: Floats, discs: Floats) -> Floats:
    """Return the distances in m of a turn, shape (NB_POINTS,); inf where it sees nothing.

    Args:
        pose: x, y in m and heading in rad of the lidar, shape (3,).
        discs: What it may see: rows x, y, radius in m, shape (3, M).
    """
    x, y = discs[:2] - pose[:2, np.newaxis]
    turned = np.arctan2(y, x) - pose[2] - _ANGLES[:, np.newaxis]
    ahead, beside = np.hypot(x, y) * (np.cos(turned), np.sin(turned))
    half_chord = np.sqrt(np.maximum(0.0, discs[2] ** 2 - beside**2))
    hits = (np.abs(beside) < discs[2]) & (ahead > 0.0)
    seen: Floats = np.where(hits, ahead - half_chord, math.inf).min(axis=1, initial=math.inf)
    return seen
