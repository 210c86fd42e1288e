"""Arrivals of measurements: how often they come, and whether anybody can steer by them."""

from __future__ import annotations

import itertools
import math
import statistics
from collections import deque

SLOWEST_HZ = 10.0
"""Rate of measurements below which people are told, in Hz."""

LONGEST_GAP_S = 0.25
"""Time in s from one to the next, twice in a row, with which nobody can steer."""

_REMEMBERED = 20


class Arrivals:
    """Remembers when the last measurements came; in s on a steady clock."""

    def __init__(self) -> None:
        """Begin before the first."""
        self._times: deque[float] = deque(maxlen=_REMEMBERED)

    def add(self, now: float) -> float:
        """Note that one has come; returns the time in s since the one before, 0 at first."""
        gap = now - self._times[-1] if self._times else 0.0
        self._times.append(now)
        return gap

    @property
    def rate(self) -> float:
        """Measurements a second, by the usual gap; inf before there are some."""
        gaps = self._gaps()
        return 1.0 / max(statistics.median(gaps), 1e-6) if len(gaps) > 2 else math.inf

    @property
    def gap(self) -> float:
        """The shorter of the last two gaps in s, for one is a hiccup of the network; 0 before."""
        gaps = self._gaps()[-2:]
        return min(gaps) if len(gaps) == 2 else 0.0

    @property
    def are_slow(self) -> bool:
        """Whether the last two gaps were too long."""
        return self.gap > LONGEST_GAP_S

    def _gaps(self) -> list[float]:
        return [later - earlier for earlier, later in itertools.pairwise(self._times)]
