"""Estimates how late messages come, from the stamps of another machine's clock."""

from __future__ import annotations

_DRIFT = 1e-3
"""Largest drift between two clocks, in s per s."""

_SLEW = 0.1
"""Largest rate in s per s at which a clock is slewed; chrony allows no more."""

_DELAY_S = 0.2
"""If the lateness in s grows by this much faster than any slew, it is a delay."""


class StampClock:
    """Estimates delays from stamps of another machine's clock.

    The smallest difference between arrival and stamp so far counts as no delay. Stamps that go
    backwards mean that the clock was set: delay cannot reverse their order, and stays what it was.
    A pause forgets that a clock was slewed, but not that a network holds messages up: its delay
    grows faster.
    """

    def __init__(self) -> None:
        self._offset: float | None = None
        self._slewed = 0.0  # the offset, as far as a slewed clock explains it
        self._stamp = self._now = 0.0
        self.repeats = 0
        """Number of measurements in a row that repeated the stamp before."""

    def lateness(self, stamp: float, now: float, paused: bool = False) -> float:
        """Return the delay of a measurement in s, compared with the smallest so far.

        Its stamp is on the sender's clock, 0 if not set (no delay then); it arrived `now` on a
        steady clock.
        """
        self.repeats = self.repeats + 1 if stamp == self._stamp != 0.0 else 0
        if stamp == 0.0:
            return 0.0
        offset = now - stamp
        if self._offset is None:
            self._offset = self._slewed = offset
        elif stamp < self._stamp:
            by = offset - (self._now - self._stamp)
            self._offset, self._slewed = self._offset + by, self._slewed + by
        step = max(0.0, now - self._now)
        is_delay = offset - self._slewed - _SLEW * step > _DELAY_S
        self._slewed = min(offset, self._slewed + (0.0 if is_delay else _SLEW * step))
        drift = 0.0 if is_delay else _SLEW if paused else _DRIFT
        self._offset = min(offset, self._offset + drift * step)
        self._stamp, self._now = stamp, now
        return offset - self._offset
