"""Tells how long the controllers have been commanding."""

from __future__ import annotations

_SILENCE_S = 2.0


class RunClock:
    """Counts from the first command that was heard, holds when they end."""

    def __init__(self) -> None:
        """Start without a run."""
        self._first: float | None = None
        self._last = 0.0

    def heard(self, now: float) -> None:
        """Note that a command came at a time in s."""
        if self._first is None or now - self._last > _SILENCE_S:
            self._first = now
        self._last = now

    def seconds(self, now: float) -> float | None:
        """Return the time of the run in s; None before the first command."""
        if self._first is None:
            return None
        return (now if now - self._last <= _SILENCE_S else self._last) - self._first
