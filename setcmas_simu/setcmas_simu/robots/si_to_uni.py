"""Conversion of single-integrator velocities to forward speeds and turn rates of unicycles."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.planar_pose import wrap_angle

SLOW = 0.01
"""Speed in m/s below which a robot counts as stopped; a TurtleBot3 cannot go slower."""

KOMEGA = 1.5
"""Default gain on the heading error, in 1/s."""

_SLOW_TURN = 0.01  # rad/s: a TurtleBot3 cannot turn slower


def si_to_uni(
    velocities: ArrayLike, theta: ArrayLike, komega: float = KOMEGA
) -> tuple[Floats, Floats]:
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
    vx, vy = np.asarray(velocities, dtype=float)
    V = np.hypot(vx, vy)
    omega = komega * wrap_angle(np.arctan2(vy, vx) - np.asarray(theta, dtype=float))
    turn = np.abs(omega)
    # Comparisons with NaN are false, so robots with a NaN stop.
    goes = np.maximum(V, turn) < np.inf
    turns = goes & (V >= SLOW) & (turn >= _SLOW_TURN)
    return np.where(goes, V, 0.0), np.where(turns, omega, 0.0)
