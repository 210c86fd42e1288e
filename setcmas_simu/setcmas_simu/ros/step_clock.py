"""Clocks that steps follow."""

from __future__ import annotations

import time
from typing import Protocol

from setcmas_simu.ros.process import RosProcess


class StepClock(Protocol):
    """A time in s, from any beginning, that never goes back."""

    def now(self) -> float:
        """Return the time."""

    def wait_until(self, t: float, process: RosProcess) -> None:
        """Serve a process until a time has come, or it is to stop; at least once."""


class SteadyClock:
    """The wall's time: setting the system's clock does not freeze who follows it."""

    def now(self) -> float:
        """Return the time."""
        return time.monotonic()

    def wait_until(self, t: float, process: RosProcess) -> None:
        """Serve a process until a time has come, or it is to stop; at least once."""
        process.serve(t - self.now())
        while not process.stopping and (left := t - self.now()) > 0.0:
            process.serve(left)
