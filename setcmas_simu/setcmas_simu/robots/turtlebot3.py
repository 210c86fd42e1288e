"""TurtleBot3 Burger and Waffle: unicycles with limits, and wheels that take time to speed up."""

from __future__ import annotations

import math

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.robots import unicycle
from setcmas_simu.robots.model import ROBOT_LIMITS, RobotModel, Shape, VelocityLimits, mirrored
from setcmas_simu.robots.unicycle import BURGER_SHAPE

WHEEL_ACCELERATION = 1.0
"""Largest acceleration of a wheel's rim in m/s^2: max_linear_acceleration of ROBOTIS' own Gazebo
models (turtlebot3_simulations). The motors' own limit is off (profile_acceleration 0)."""

LAG_S = 0.1
"""Time constant in s of a wheel's speed. Assumed: we know of no published measurement. To measure
yours, find where the speed reaches 63 % of a step of cmd_vel."""


class TurtleBot3(RobotModel):
    """TurtleBot3: velocity limits of its firmware, wheels with limited acceleration and lag.

    Each wheel's speed w approaches its command u with time constant T and acceleration at most a:
    w+ = w + clip((1 - exp(-Ts/T)) (u - w), -a Ts, a Ts), where u is the command within the
    firmware's limits (VelocityLimits), held over the period.
    """

    def __init__(
        self,
        limits: VelocityLimits,
        shape: Shape,
        acceleration: float = WHEEL_ACCELERATION,
        lag: float = LAG_S,
    ) -> None:
        """Describe the robot; acceleration (m/s^2) and time constant `lag` (s) are a wheel's."""
        self.shape = shape
        self.V_max = limits.V_max
        self.limits = limits
        self._acceleration = acceleration
        self._lag = lag

    def step(self, states: Floats, commands: Floats, Ts: float) -> Floats:
        """Return the states one period later."""
        half = 0.5 * self.limits.wheel_separation
        V, omega = self.limits.saturate(commands[0], commands[2])
        wanted = np.stack([V - half * omega, V + half * omega])
        speeds = np.stack([states[3] - half * states[5], states[3] + half * states[5]])
        most = self._acceleration * Ts
        change = (1.0 - math.exp(-Ts / self._lag)) * (wanted - speeds)
        left, right = speeds + np.clip(change, -most, most)
        return unicycle.driven(states, 0.5 * (left + right), (right - left) / (2.0 * half), Ts)


BURGER = TurtleBot3(ROBOT_LIMITS['burger'], BURGER_SHAPE)
"""Limits of its OpenCR firmware; 138 x 178 x 192 mm (ROBOTIS' manual)."""

WAFFLE = TurtleBot3(
    ROBOT_LIMITS['waffle'],
    Shape(
        mirrored(
            (
                *((0.2, 0.0), (0.077, 0.06), (0.05, 0.12)),
                *((0.02, 0.153), (-0.16, 0.153), (-0.204, 0.08)),
            )
        ),
        mirrored(((0.077, 0.08), (0.03, 0.131), (-0.16, 0.131), (-0.204, 0.08))),
        0.141,
    ),
)
"""Limits of its OpenCR firmware; 281 x 306 x 141 mm, with its axle ahead of the centre."""
