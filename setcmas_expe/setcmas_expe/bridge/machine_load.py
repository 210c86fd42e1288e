"""Load of this machine: whether processes wait for its processors, and stalls of this process."""

from __future__ import annotations

import contextlib
import time
from collections import deque
from pathlib import Path

_AFTERWARDS_S = 1.0  # until messages sent during a stall have arrived


def time_since_boot() -> float:
    """Return the time in s on a steady clock that runs while the machine is asleep.

    `time.monotonic` does not: it misses the hour for which a laptop was closed.
    """
    if hasattr(time, 'CLOCK_BOOTTIME'):  # Linux
        return time.clock_gettime(time.CLOCK_BOOTTIME)
    return time.monotonic()


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


PRESSURE = Path('/proc/pressure/cpu')
"""Linux' pressure stall information: for how long processes waited for a processor."""

OVERLOADED = 'this computer is overloaded; if processes answer late, end other programs'

_OVERLOAD = 0.8  # share of the time in which a process waited
_LOOK_EVERY_S = 0.5
_NB_LOOKS = 5


class ProcessorLoad:
    """Measures over two seconds whether processes wait for processors; steady times in s."""

    def __init__(self, pressure: Path = PRESSURE) -> None:
        """Read from a file of the kernel; without it no load is known."""
        self._pressure = pressure
        self._waited: deque[tuple[float, float]] = deque(maxlen=_NB_LOOKS)

    def look(self, now: float) -> None:
        """Measure again when due."""
        if self._waited and now - self._waited[-1][0] < _LOOK_EVERY_S:
            return
        with contextlib.suppress(OSError, ValueError):
            some = self._pressure.read_text().partition('\n')[0]
            self._waited.append((now, 1e-6 * int(some.partition('total=')[2])))

    @property
    def is_overload(self) -> bool:
        """Whether processes waited most of the time."""
        if len(self._waited) < _NB_LOOKS:
            return False
        (begin, before), (end, after) = self._waited[0], self._waited[-1]
        return after - before > _OVERLOAD * (end - begin)
