"""Load of this machine: whether processes wait for its processors, and stalls of this process."""

from __future__ import annotations

import os
import time
from collections.abc import Callable

_AFTERWARDS_S = 1.0  # until messages sent during a stall have arrived


def time_since_boot() -> float:
    """Return the time in s on a steady clock that runs while the machine is asleep.

    `time.monotonic` does not: it misses the hour for which a laptop was closed.
    """
    return time.clock_gettime(time.CLOCK_BOOTTIME)


class StallDetector:
    """Finds gaps between ticks: the process was stopped, starved, or asleep with the machine."""

    def __init__(self, longest_s: float, now: float) -> None:
        """Start at a time since boot (s); gaps above `longest_s` count as stalls."""
        self._longest_s = longest_s
        self._ticked = now
        self._ended = -float('inf')

    def tick(self, now: float) -> float:
        """Note a tick; return the duration of the stall before it in s, 0 if there was none."""
        gap = now - self._ticked
        self._ticked = now
        if gap <= self._longest_s:
            return 0.0
        self._ended = now
        return gap

    def recent(self, now: float) -> bool:
        """Return whether messages that arrive now may have been sent before a stall ended."""
        return now - self._ticked > self._longest_s or now - self._ended < _AFTERWARDS_S


OVERLOADED = 'this computer is overloaded; if processes answer late, end other programs'


def warn_of_load(warn: Callable[[str], object]) -> None:
    """Warn if processes have waited for processors in the last minute: they may answer late."""
    if os.getloadavg()[0] > 1.5 * (os.cpu_count() or 1):
        warn(OVERLOADED)
