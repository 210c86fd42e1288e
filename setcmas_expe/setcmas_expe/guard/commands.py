"""Commands that a guard has heard: the newest one, unless it is late or too old."""

from __future__ import annotations

import math

from setcmas_expe.mocap.stamp_clock import StampClock

SILENCE_S = 0.3
"""Silence in s, after a command to move, from which the guard stops the robot."""

LATEST_S = 0.2
"""By how much a command may come later than the promptest ones, in s."""

ENDED = 'its commands have ended'

Velocities = tuple[float, float]


class Commands:
    """The commands of one source.

    How late one comes is judged by its stamp. The clocks of two machines differ, so the least
    difference between arrival and stamp that was seen stands for a command that came at once.
    """

    def __init__(self, silence_s: float = SILENCE_S) -> None:
        """Begin without any."""
        self._silence_s = silence_s
        self.forget()

    def forget(self) -> None:
        """Begin anew: with another source, another clock."""
        self._clock = StampClock()
        self._newest = (0.0, 0.0)
        self._heard = -math.inf
        self._late = 0.0

    def hear(self, V: float, omega: float, stamp: float, now: float) -> None:
        """Take a command; one that is late, or not a number, is not followed.

        Args:
            V: Forward speed in m/s.
            omega: Turn rate in rad/s.
            stamp: When it was sent, in s on the sender's clock; 0 if it does not tell.
            now: Time in s on a steady clock.
        """
        self._late = self._clock.lateness(stamp, now)
        if self._late <= LATEST_S and math.isfinite(V) and math.isfinite(omega):
            self._newest, self._heard = (V, omega), now

    def newest(self, now: float) -> Velocities | None:
        """Return what to follow (m/s, rad/s); None if there is nothing that may be."""
        return self._newest if now - self._heard < self._silence_s else None

    @property
    def trouble(self) -> str:
        """Why there is nothing to follow."""
        return f'its commands come {self._late:.1f} s late' if self._late > LATEST_S else ENDED
