"""Due times of what happens at a rate."""

from __future__ import annotations


class Schedule:
    """Tells when something that happens at a rate is due."""

    def __init__(self, rate: float) -> None:
        """Prepare for a rate in Hz."""
        self._period = 1.0 / rate
        self._next = 0.0

    def due(self, now: float) -> bool:
        """Return whether it is due at time now (s), once for each period."""
        if now < self._next:
            return False
        # Half a step early or late keeps the rate; a long gap is not made up for.
        self._next = max(self._next + self._period, now + 0.5 * self._period)
        return True
