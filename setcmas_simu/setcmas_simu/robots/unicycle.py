"""The unicycle: drives along its heading and turns on the spot."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.planar_pose import wrap_angle
from setcmas_simu.robots.model import IDEAL, RobotModel, Shape, VelocityLimits, mirrored

RATE_HZ = 10.0
"""Default rate at which robots are integrated, in Hz."""

DART = ((0.07, 0.0), (-0.056, 0.049), (-0.028, 0.0), (-0.056, -0.049))
"""Outline in m, pointing along the heading; about as long as a TurtleBot3 Burger."""

BURGER_SHAPE = Shape(
    DART, mirrored(((0.069, 0.035), (0.035, 0.069), (-0.05, 0.069), (-0.075, 0.045))), 0.192
)
"""A TurtleBot3 Burger."""


class Unicycle(RobotModel):
    """Unicycle, the robot of the ROS 1 stack: follows its command at once, within its limits."""

    shape = BURGER_SHAPE

    def __init__(self, limits: VelocityLimits = IDEAL) -> None:
        """Set the velocity limits; none by default."""
        self.limits = limits
        self.V_max = limits.V_max

    def step(self, states: Floats, commands: Floats, Ts: float) -> Floats:
        """Return the states one period later."""
        V, omega = self.limits.saturate(commands[0], commands[2])
        return driven(states, V, omega, Ts)


def step(states: Floats, V: Floats | float, omega: Floats | float, Ts: float) -> Floats:
    """Integrate unicycles: return their states Ts s later, in a new array.

    theta+ = theta + Ts omega, then x+ = x + Ts V cos(theta+) and y+ = y + Ts V sin(theta+): the
    semi-implicit Euler scheme of the kinematic unicycle (Siciliano et al., Robotics, 2009, section
    11.2.1), in the order of the ROS 1 stack. Simulated robots with two driven wheels all move by
    this function, over ROS and offline.

    Args:
        states: Rows x, y in m and theta in rad, and any others, which stay; shape (3+, N).
        V: Forward speeds in m/s, shape (N,).
        omega: Turn rates in rad/s, shape (N,). The heading is not wrapped.
        Ts: Period in s.
    """
    way = Ts * V
    theta = states[2] + Ts * omega
    later: Floats = states.copy()
    later[0] = states[0] + way * np.cos(theta)
    later[1] = states[1] + way * np.sin(theta)
    later[2] = theta
    return later


def driven(states: Floats, V: Floats, omega: Floats, Ts: float) -> Floats:
    """Return the states after `step`, with V and omega as the velocities of this step."""
    later = step(states, V, omega, Ts)
    later[3], later[5] = V, omega
    return later


def velocities_between(before: ArrayLike, after: ArrayLike, Ts: float) -> tuple[Floats, Floats]:
    """Return forward speeds (m/s) and turn rates (rad/s) between poses (3,) or (3, N) Ts s apart.

    They are backward differences: the speed is the displacement along the later heading, as in
    `step`; sideways displacement is ignored.
    """
    x0, y0, theta0 = np.asarray(before, dtype=float)
    x1, y1, theta1 = np.asarray(after, dtype=float)
    V = ((x1 - x0) * np.cos(theta1) + (y1 - y0) * np.sin(theta1)) / Ts
    return V, wrap_angle(theta1 - theta0) / Ts


UNICYCLE = Unicycle()
"""Without limits."""
