"""si_to_uni: turns the velocity of a law, vx and vy, into the command of a robot, V and omega.

The function `si_to_uni` converts; change it, and every unicycle is driven your way, over ROS and
offline. `velocity_conversion.py` is what surrounds it: other kinds of robots, limited
acceleration, velocities that the safety filter has changed.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.planar_pose import wrap_angle
from setcmas_simu.robots.model import SLOW, RobotModel

_SLOW_TURN = 0.01  # rad/s: a TurtleBot3 cannot turn slower


def si_to_uni(velocities: ArrayLike, theta: ArrayLike, komega: float) -> tuple[Floats, Floats]:
    """Turn robots towards their desired velocities and drive at their speed.

    V = |v| and omega = komega wrap(atan2(vy, vx) - theta): the proportional heading control of
    the ROS 1 stack (Bertrand, ECC 2024), with the error wrapped so that robots turn the short
    way. A robot slower than 0.01 m/s does not turn, and turn rates below 0.01 rad/s become 0.
    A robot whose velocity or heading is not finite stops.

    Args:
        velocities: Rows vx, vy in m/s in the world frame, shape (2, N).
        theta: Headings in rad, shape (N,).
        komega: Gain on the heading error in 1/s.

    Returns:
        Forward speeds in m/s and turn rates in rad/s, shapes (N,).
    """
    v = np.asarray(velocities, dtype=float)
    V = np.asarray(np.hypot(v[0], v[1]))
    omega = np.asarray(komega * wrap_angle(np.arctan2(v[1], v[0]) - theta))
    turn = np.abs(omega)
    goes = np.isfinite(V + turn)
    turns = goes & (V >= SLOW) & (turn >= _SLOW_TURN)
    V[~goes] = omega[~turns] = 0.0
    return V, omega


Conversion = Callable[[Floats, Floats, float], Floats]
"""From velocities (2, N) and poses (3, N) of robots, and komega in 1/s, to commands (3, N)."""


def as_unicycles(velocities: Floats, poses: Floats, komega: float) -> Floats:
    """Return the commands of unicycles by `si_to_uni`: V (m/s), zeros, omega (rad/s); (3, N)."""
    commands = np.zeros(poses.shape)
    commands[0], commands[2] = si_to_uni(velocities, poses[2], komega)
    return commands


def conversion_of(model: RobotModel, otherwise: Conversion = as_unicycles) -> Conversion:
    """Return how robots of a model are driven: by its own method `command`, if it has one."""
    own: Conversion | None = getattr(model, 'command', None)
    return own or otherwise
