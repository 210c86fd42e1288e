"""Velocity limits of a robot: saturation of forward speed and turn rate."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError

Velocities = tuple[Floats, Floats]


@dataclass(frozen=True)
class VelocityLimits:
    """Velocity limits of a differential-drive robot.

    Attributes:
        V_max: Largest forward or backward speed, in m/s.
        omega_max: Largest turn rate, in rad/s.
        wheel_speed_max: Largest rim speed of a wheel, in m/s.
        wheel_separation: Distance between the wheels, in m.
    """

    V_max: float
    omega_max: float
    wheel_speed_max: float
    wheel_separation: float

    def saturate(self, V: ArrayLike, omega: ArrayLike) -> Velocities:
        """Clamp forward speed and turn rate separately, then each wheel, as OpenCR firmware does.

        Args:
            V: Forward speeds in m/s, shape (N,).
            omega: Turn rates in rad/s, shape (N,).

        Returns:
            Reachable forward speeds (m/s) and turn rates (rad/s), shapes (N,).
        """
        forward, turn = np.asarray(V, dtype=float), np.asarray(omega, dtype=float)
        if self is IDEAL:
            return forward, turn
        forward = np.clip(forward, -self.V_max, self.V_max)
        turn = np.clip(turn, -self.omega_max, self.omega_max)
        half = 0.5 * self.wheel_separation * turn
        left = np.clip(forward - half, -self.wheel_speed_max, self.wheel_speed_max)
        right = np.clip(forward + half, -self.wheel_speed_max, self.wheel_speed_max)
        return 0.5 * (left + right), (right - left) / self.wheel_separation

    def scaled_down(self, V: float, omega: float) -> tuple[float, float]:
        """Scale forward speed and turn rate by one factor, which keeps the curvature of the path.

        Args:
            V: Forward speed in m/s.
            omega: Turn rate in rad/s.

        Returns:
            The largest speeds (m/s, rad/s), up to those given, of the same ratio that keep
            forward speed, turn rate and both wheels within their limits.
        """
        wheel = self.faster_wheel(V, omega)
        excess = max(
            1.0, abs(V) / self.V_max, abs(omega) / self.omega_max, wheel / self.wheel_speed_max
        )
        return V / excess, omega / excess

    def faster_wheel(self, V: float, omega: float) -> float:
        """Return the rim speed of the faster wheel in m/s, forward or backward."""
        return abs(V) + 0.5 * self.wheel_separation * abs(omega)


IDEAL = VelocityLimits(math.inf, math.inf, math.inf, 0.160)
"""No limits, as in ROS 1."""

ROBOT_MODELS = {
    'burger': VelocityLimits(0.2108, 2.635, 0.2667, 0.160),
    'waffle': VelocityLimits(0.2661, 1.854, 0.2667, 0.287),
}
"""Limits of real robots by name, from the firmware of the TurtleBot3 models."""

MODELS = {'ideal': IDEAL, **ROBOT_MODELS}
"""Limits of simulated robots by name."""


def limits_named(name: str) -> VelocityLimits:
    """Return the limits with this name.

    Raises:
        SetcmasError: The name is unknown.
    """
    if name not in MODELS:
        raise SetcmasError(f"unknown limits '{name}'; must be one of {', '.join(MODELS)}")
    return MODELS[name]
