"""Gaps in the motion of a robot: times without data, and resets, which put it somewhere else."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats
from setcmas_tools.records.fleet_table import FleetTable

LONGEST_GAP_S = 1.0
"""Over longer gaps between two samples of a robot nothing is interpolated."""

_NOISE_M = 0.1
_LEAST_M_S = 1.0


def farthest_drive(speed: float, seconds: float | Floats) -> float | Floats:
    """Return how far in m a robot may have driven; farther off, it was put somewhere else.

    Args:
        speed: Largest speed that its odometry tells of in m/s; half of what is allowed for.
        seconds: The time it had in s.
    """
    return _NOISE_M + max(_LEAST_M_S, 2 * speed) * seconds


def resets(track: FleetTable) -> NDArray[np.bool_]:
    """Return between which rows of one robot it was put somewhere else, shape (rows - 1,).

    None is told of a robot whose odometry has no speed: it says nothing of how far it can drive.
    """
    speeds = np.abs(track.v[np.isfinite(track.v)])
    if not (fastest := float(speeds.max(initial=0.0))):
        return np.zeros(max(0, len(track.t) - 1), bool)
    steps = np.hypot(np.diff(track.x), np.diff(track.y))
    return np.asarray(steps > farthest_drive(fastest, np.diff(track.t)))


def gaps(track: FleetTable) -> NDArray[np.bool_]:
    """Return between which rows of one robot nothing is known of its way, shape (rows - 1,)."""
    return np.asarray((np.diff(track.t) > LONGEST_GAP_S) | resets(track))
