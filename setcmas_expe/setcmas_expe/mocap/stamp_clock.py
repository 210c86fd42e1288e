"""Age of measurements whose stamps are from another machine's clock."""

from __future__ import annotations

_DRIFT = 1e-3
"""By how much two clocks may drift apart, in s per s."""


class StampClock:
    """Compares stamps with the time of arrival.

    The smallest difference that was seen stands for a measurement that came at once; what exceeds
    it is lateness. Stamps that go backwards mean that the clock was set: delay alone cannot
    reverse them.
    """

    def __init__(self) -> None:
        """Know nothing yet."""
        self._offset: float | None = None
        self._stamp = self._now = 0.0

    def lateness(self, stamp: float, now: float) -> float:
        """Return by how much a measurement is later than the promptest ones, in s.

        Args:
            stamp: On the sender's clock in s; 0 if not given, which counts as prompt.
            now: Time of arrival on a steady clock in s.
        """
        if stamp == 0.0:
            return 0.0
        offset = now - stamp
        if self._offset is None or stamp < self._stamp:
            self._offset = offset
        self._offset = min(offset, self._offset + _DRIFT * max(0.0, now - self._now))
        self._stamp, self._now = stamp, now
        return offset - self._offset
