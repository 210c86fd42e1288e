"""TurtleBot3s: unicycles with limits, wheels that take time to speed up, and lag of the motors."""

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
"""Time constant in s with which a wheel follows. Assumed: no measurement has been published that
we know of. Yours is where 63 % of a step of cmd_vel is reached."""


class TurtleBot3(RobotModel):
    """TurtleBot3: limits of its firmware, wheels that take time to follow their command.

    Each wheel's speed w approaches the commanded one u with the time constant T, by no more than
    the acceleration a allows: w+ = w + clip((1 - exp(-Ts/T)) (u - w), -a Ts, a Ts), where u is
    what the firmware lets through (VelocityLimits) and held over the period.
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
            limits: Those of its firmware.
            shape: What it looks like.
            acceleration: Largest acceleration of a wheel's rim in m/s^2.
            lag: Time constant of a wheel's speed in s.
        """
        self.shape = shape
        self.V_max = limits.V_max
        self.limits = limits
        self._acceleration = acceleration
        self._lag = lag

    def step(self, states: Floats, commands: Floats, Ts: float) -> Floats:
        """Return the states a period later."""
        half = 0.5 * self.limits.wheel_separation
        V, omega = self.limits.saturate(commands[0], commands[2])
        wanted = np.stack([V - half * omega, V + half * omega])
        speeds = np.stack([states[3] - half * states[5], states[3] + half * states[5]])
        most = self._acceleration * Ts
        change = (1.0 - math.exp(-Ts / self._lag)) * (wanted - speeds)
        left, right = speeds + np.clip(change, -most, most)
        return unicycle.driven(states, 0.5 * (left + right), (right - left) / (2.0 * half), Ts)
