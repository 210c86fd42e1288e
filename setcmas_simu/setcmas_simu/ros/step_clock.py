"""Clocks for steps: real time and scaled time."""

from __future__ import annotations

import time
from typing import Protocol

from setcmas_simu.ros import ros_time
from setcmas_simu.ros.process import RosProcess


class Clock(Protocol):
    """A time in s, from any origin, that never goes back."""

    def now(self) -> float:
        """Return the time."""


class StepClock(Clock, Protocol):
    """A clock to wait on.

    Attributes:
        rtf: Real time factor: its seconds per second of real time.
    """

    rtf: float

    def wait_until(self, t: float, process: RosProcess) -> None:
        """Serve a process until a time or a stop request; at least one callback."""


class SteadyClock:
    """Real time, independent of changes of the system clock."""

    rtf = 1.0

    def now(self) -> float:
        """Return the time."""
        return time.monotonic()

    def wait_until(self, t: float, process: RosProcess) -> None:
        """Serve a process until a time or a stop request; at least one callback."""
        process.serve(t - self.now())
        while not process.stopping and (left := t - self.now()) > 0.0:
            process.serve(left)


class ScaledClock:
    """Time that runs faster or slower than real time, also in message stamps.

    Attributes:
        begin: The system clock at its time 0, in s.
        rtf: Real time factor: its seconds per second of real time.
    """

    def __init__(self, rtf: float, begin: float | None = None) -> None:
        """Start the clock.

        Args:
            rtf: Real time factor: its seconds per second of real time.
            begin: The system clock at its time 0, in s; now by default.
        """
        self.begin = time.time() if begin is None else begin
        self.rtf = rtf
        # Read once: later changes of the system clock have no effect.
        self._offset = time.monotonic() - (time.time() - self.begin)
        ros_time.now_ns = lambda: round(self.now() * 1e9)

    def now(self) -> float:
        """Return the time."""
        return (time.monotonic() - self._offset) * self.rtf

    def wait_until(self, t: float, process: RosProcess) -> None:
        """Serve a process until a time or a stop request; at least one callback."""
        process.serve((t - self.now()) / self.rtf)
        while not process.stopping and (left := t - self.now()) > 0.0:
            process.serve(left / self.rtf)
