"""Tables of an offline run."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl import drawing
from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.planar_pose import through_quaternion
from setcmas_tools.run.fleet_motion import FleetTable
from setcmas_tools.run.law_output import Commands, DrawingRecord, Filtered


def motion(t: Floats, poses: Floats, V: Floats, omega: Floats) -> FleetTable:
    """Return the table of a fleet's states.

    Args:
        t: Times in s, shape (K,).
        poses: Rows x, y in m and theta in rad as simulated, shape (K, 3, N).
        V: Forward speeds over the step that led to each state in m/s, shape (K, N).
        omega: Turn rates over that step in rad/s, shape (K, N).
    """
    times, robots = _rows(t, poses.shape[2])
    x, y, theta = through_quaternion(poses.transpose(1, 0, 2).reshape(3, -1))
    return FleetTable(times, robots, x, y, theta, V.ravel(), omega.ravel())


def commands(t: Floats, velocities: Floats) -> Commands:
    """Return the commands of a fleet, in single precision as cmd_cart_vel carries them.

    Args:
        t: Times in s at which the laws were called, shape (C,).
        velocities: Wanted velocities after saturation: rows vx, vy in m/s, shape (C, 2, N); with
            a filter also the allowed velocities and its verdicts, shape (C, 5, N).
    """
    times, robots = _rows(t, velocities.shape[2])
    carried = velocities.astype(np.float32).astype(float)
    vx, vy, *allowed = carried.transpose(1, 0, 2).reshape(velocities.shape[1], -1)
    return Commands(times, robots, vx, vy, Filtered(*allowed) if allowed else None)


@contextmanager
def recorded_drawings() -> Iterator[DrawingRecord]:
    """Record the drawings of scripts meanwhile."""
    before = drawing.canvas
    drawing.canvas = record = DrawingRecord()
    try:
        yield record
    finally:
        drawing.canvas = before


def _rows(t: Floats, nb_robots: int) -> tuple[Floats, NDArray[np.int64]]:
    robots = np.arange(1, nb_robots + 1, dtype=np.int64)
    return np.repeat(t, nb_robots), np.tile(robots, len(t))
