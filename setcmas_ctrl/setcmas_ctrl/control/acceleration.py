"""Limit on how fast the speed of a robot may rise."""

from __future__ import annotations

import math

import numpy as np

from setcmas_simu.arrays import Floats


def limited_rise(commands: Floats, before: Floats, most: float) -> Floats:
    """Return commands whose speeds are not much above those before; slowing down is never limited.

    Args:
        commands: Speeds forward and to the left (m/s) and turn rates (rad/s), shape (3, N).
        before: The commands before them.
        most: By how much the speed in the direction of a command may rise, in m/s.

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
