"""Clock of the run: how long controllers have been commanding."""

from __future__ import annotations

_SILENCE_S = 2.0


class RunClock:
    """Counts from the first command that was heard, holds when they end or are paused.

    Where a simulation has a time of its own, that is counted.
    """

    def __init__(self) -> None:
        """Start without a run."""
        self._counted: float | None = None
        self._last = 0.0
        self._paused = False
        self._simulated: float | None = None
        self._first_simulated = 0.0

    def follow(self, simulated: float) -> None:
        """Note what time it is in a simulation, in s."""
        if self._simulated is None or simulated < self._first_simulated:
            self._first_simulated = simulated
        self._simulated = simulated

    def heard(self, now: float, paused: bool = False) -> None:
        """Note that a command came at a time in s.

        Args:
            now: Time in s.
            paused: Whether the control laws' own time stands still.
        """
        if self._counted is None or now - self._last > _SILENCE_S:
            self._counted = 0.0
        elif not self._paused:
            self._counted += now - self._last
        self._last, self._paused = now, paused

    def describe(self, now: float) -> str:
        """Return in words whether controllers command the robots."""
        if self._counted is None:
            return 'not controlled yet'
        return 'control has ended' if now - self._last > _SILENCE_S else 'running'

    def seconds(self, now: float) -> float | None:
        """Return the time of the run in s; None before the first command."""
        if self._counted is None:
            return None
        if self._simulated is not None:
            return self._simulated - self._first_simulated
        since = now - self._last
        return self._counted + (0.0 if self._paused or since > _SILENCE_S else since)
