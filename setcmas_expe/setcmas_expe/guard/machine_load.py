"""Load of this machine: whether processes wait for its processors."""

from __future__ import annotations

import contextlib
from collections import deque
from pathlib import Path

PRESSURE = Path('/proc/pressure/cpu')
"""Linux' pressure stall information: for how long processes waited for a processor."""

OVERLOADED = 'this computer is overloaded, so processes answer late: end other programs'

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
