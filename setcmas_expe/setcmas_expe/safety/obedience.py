"""Obedience of a robot: whether its wheels do what it is commanded, by its own odometry."""

from __future__ import annotations

AFTER_S = 0.7
"""Time in s that a robot may take to follow."""

_COMMANDED_M_S = 0.05
_STANDS_M_S = 0.01
_TURNS_M_S = 0.03
_SILENT_AFTER_S = 1.0
_OLD_S = 0.3  # what is older tells nothing of wheels that turn


class Obedience:
    """Compares commands with the speed of the wheels; all times in s on a steady clock."""

    def __init__(self) -> None:
        """Begin without having heard of the wheels."""
        self._wheels = 0.0
        self._heard: float | None = None
        self._follows = self._stops = 0.0  # when it last did as it was commanded

    def hear(self, V: float, now: float) -> None:
        """Take the forward speed (m/s) that the wheels had."""
        if self._heard is None:
            self._follows = self._stops = now
        self._wheels, self._heard = abs(V), now

    def update(self, V: float, is_zero: bool, now: float) -> str:
        """Take what was commanded last; returns what is wrong with the robot, empty if nothing.

        Args:
            V: Forward speed in m/s.
            is_zero: Whether it was commanded to stand.
            now: The time.
        """
        if self._heard is None:
            return ''
        if now - self._heard > _SILENT_AFTER_S:
            self._follows = self._stops = now
            return 'its wheel odometry is silent; is it switched off?'
        if abs(V) <= _COMMANDED_M_S or self._wheels > _STANDS_M_S:
            self._follows = now
        if not is_zero or self._wheels <= _TURNS_M_S or now - self._heard > _OLD_S:
            self._stops = now
        if now - self._follows > AFTER_S:
            return 'its wheels stand, although it is commanded to move: are its motors on?'
        if now - self._stops > AFTER_S:
            return 'its wheels turn, although it is commanded zero'
        return ''
