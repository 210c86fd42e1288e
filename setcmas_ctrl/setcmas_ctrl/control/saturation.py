"""Saturation of velocities and of their rise; dead band for slow ones."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from setcmas_simu.arrays import Floats
from setcmas_simu.robots.model import SLOW

VNOM = 0.5
"""Default largest speed of a robot, in m/s."""


def saturate(velocities: ArrayLike, vnom: float = VNOM) -> Floats:
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


def limited_rise(commands: Floats, before: Floats, most: float) -> Floats:
    """Limit how much speeds may rise over the previous commands; never limit slowing down.

    Args:
        commands: Speeds forward and to the left (m/s) and turn rates (rad/s), shape (3, N).
        before: The previous commands.
        most: Largest rise in m/s of the speed in the direction of a command.

    Returns:
        The commands, with the same turn rates.
    """
    if most == math.inf:
        return commands
    speeds = np.hypot(commands[0], commands[1])
    directions = commands[:2] / np.maximum(speeds, 1e-12)
    reached = np.maximum(0.0, (directions * before[:2]).sum(axis=0)) + most
    limited: Floats = commands.copy()
    limited[:2] = directions * np.minimum(speeds, reached)
    return limited
