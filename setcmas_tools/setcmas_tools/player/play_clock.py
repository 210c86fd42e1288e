"""Clock of a player: the time in a recording while it plays or is paused."""

from __future__ import annotations

from setcmas_simu.reports.reports import Message


class PauseToggled(Message, frozen=True):
    """The pause key was pressed in the terminal."""


class PlayClock:
    """The time in s since the first message of a recording.

    Attributes:
        paused: Whether the time stops.
    """

    def __init__(self, rate: float, at: float, now: float) -> None:
        """Start at a time in the recording.

        Args:
            rate: How many times as fast as the steady clock it goes.
            at: Time in the recording in s.
            now: Time of the steady clock in s.
        """
        self.paused = False
        self._rate = rate
        self._at = at
        self._since = now

    def at(self, now: float) -> float:
        """Return the time in the recording at a time of the steady clock."""
        return self._at if self.paused else self._at + self._rate * (now - self._since)

    def wait_s(self, at: float, now: float) -> float:
        """Return the time in s until a time in the recording comes, at least 0."""
        return max(0.0, (at - self.at(now)) / self._rate)

    def turn(self, rate: float, now: float) -> None:
        """Continue at another rate."""
        self.move_to(self.at(now), now)
        self._rate = rate

    def toggle(self, now: float) -> None:
        """Pause, or resume."""
        self.move_to(self.at(now), now)
        self.paused = not self.paused

    def move_to(self, at: float, now: float) -> None:
        """Continue from a time in the recording."""
        self._at, self._since = at, now
