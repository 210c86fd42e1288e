"""Detector of stalls of this process, after which nothing it knew may be true any more."""

from __future__ import annotations

import time

_AFTERWARDS_S = 1.0  # what was sent during a hold-up has come in by then


def time_since_boot() -> float:
    """Return the time in s on a steady clock that goes on while the machine is asleep.

    `time.monotonic` stands still then: to it, a laptop that was closed for an hour has not
    missed anything.
    """
    if hasattr(time, 'CLOCK_BOOTTIME'):  # Linux
        return time.clock_gettime(time.CLOCK_BOOTTIME)
    return time.monotonic()


class StallDetector:
    """Watches for gaps between signs of life: stopped, starved, or asleep with the machine."""

    def __init__(self, longest_s: float, now: float) -> None:
        """Begin at a time.

        Args:
            longest_s: Gap in s from which the process counts as held up.
            now: Time since boot in s.
        """
        self._longest_s = longest_s
        self._lived = now
        self._ended = -float('inf')

    def tick(self, now: float) -> float:
        """Take a sign of life; returns how long the process was held up before, 0 if not."""
        gap = now - self._lived
        self._lived = now
        if gap <= self._longest_s:
            return 0.0
        self._ended = now
        return gap

    def recent(self, now: float) -> bool:
        """Return whether what comes in now may have been sent before a hold-up was over."""
        return now - self._lived > self._longest_s or now - self._ended < _AFTERWARDS_S
