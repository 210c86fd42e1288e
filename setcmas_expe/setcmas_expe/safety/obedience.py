"""Obedience of a robot: whether its wheels do what it is commanded, by its own odometry."""

from __future__ import annotations

from setcmas_simu.robots.velocity_limits import VelocityLimits

AFTER_S = 0.7
"""Time in s that a robot may take to follow."""

_COMMANDED_M_S = 0.05
_STANDS_M_S = 0.01
_TURNS_M_S = 0.03
_SILENT_AFTER_S = 1.0
_OLD_S = 0.3  # what is older tells nothing of wheels that turn


class Obedience:
    """Compares commands with the speed of the wheels; all times in s on a steady clock."""

    def __init__(self, limits: VelocityLimits) -> None:
        """Begin without having heard of the wheels of a robot."""
        self._limits = limits
        self._wheels = 0.0
        self._heard: float | None = None
        self._follows = self._stops = 0.0  # when it last did as it was commanded

    def hear(self, V: float, omega: float, now: float) -> None:
        """Take the forward speed (m/s) and the turn rate (rad/s) that the wheels had."""
        if self._heard is None:
            self._follows = self._stops = now
        self._wheels, self._heard = self._limits.faster_wheel(V, omega), now

    def update(self, V: float, omega: float, now: float) -> str:
        """Take what was commanded last; returns what is wrong with the robot, empty if nothing.

        Args:
            V: Forward speed in m/s.
            omega: Turn rate in rad/s.
            now: The time.
        """
        if self._heard is None:
            return ''
        if now - self._heard > _SILENT_AFTER_S:
            self._follows = self._stops = now
            return 'its wheel odometry is silent; is it switched off?'
        if self._wheels > _STANDS_M_S or self._limits.faster_wheel(V, omega) <= _COMMANDED_M_S:
            self._follows = now
        if V or omega or self._wheels <= _TURNS_M_S or now - self._heard > _OLD_S:
            self._stops = now
        if now - self._follows > AFTER_S:
            return 'its wheels stand, although it is commanded to move: are its motors on?'
        if now - self._stops > AFTER_S:
            return 'its wheels turn, although it is commanded zero'
        return ''
