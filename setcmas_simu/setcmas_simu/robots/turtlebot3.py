"""TurtleBot3s: unicycles with velocity limits, limited wheel acceleration, and motor lag."""

from __future__ import annotations

import math

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.robots import unicycle
from setcmas_simu.robots.model import RobotModel
from setcmas_simu.robots.shape import Shape
from setcmas_simu.robots.velocity_limits import VelocityLimits

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
        """Describe the robot.

        Args:
            limits: Velocity limits of its firmware.
            shape: Shape of the robot.
            acceleration: Largest acceleration of a wheel's rim in m/s^2.
            lag: Time constant of a wheel's speed in s.
        """
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
