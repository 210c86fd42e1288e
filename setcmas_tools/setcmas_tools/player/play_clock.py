"""Clock of a player: time in a recording as time passes, stopped, or set."""

from __future__ import annotations


class PlayClock:
    """Tells the time in s since the first message of a recording.

    Attributes:
        paused: Whether it stands still.
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
        """Return how long in s it is until a time in the recording comes; never less than 0."""
        return max(0.0, (at - self.at(now)) / self._rate)

    def turn(self, rate: float, now: float) -> None:
        """Go on at another rate."""
        self.move_to(self.at(now), now)
        self._rate = rate

    def toggle(self, now: float) -> None:
        """Stop if it goes, else go on."""
        self.move_to(self.at(now), now)
        self.paused = not self.paused

    def move_to(self, at: float, now: float) -> None:
        """Go on from a time in the recording."""
        self._at, self._since = at, now
