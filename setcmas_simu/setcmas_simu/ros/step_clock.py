"""Clocks for steps: the wall's time, and a scaled one."""

from __future__ import annotations

import time
from typing import Protocol

from setcmas_simu.ros import ros_time
from setcmas_simu.ros.process import RosProcess


class Clock(Protocol):
    """A time in s, from any beginning, that never goes back."""

    def now(self) -> float:
        """Return the time."""


class StepClock(Clock, Protocol):
    """A time that can be waited for.

    Attributes:
        rtf: How many seconds of it pass in a second of the wall's.
    """

    rtf: float

    def wait_until(self, t: float, process: RosProcess) -> None:
        """Serve a process until a time has come, or it is to stop; at least once."""


class SteadyClock:
    """The wall's time: setting the system's clock does not freeze who follows it."""

    rtf = 1.0

    def now(self) -> float:
        """Return the time."""
        return time.monotonic()

    def wait_until(self, t: float, process: RosProcess) -> None:
        """Serve a process until a time has come, or it is to stop; at least once."""
        process.serve(t - self.now())
        while not process.stopping and (left := t - self.now()) > 0.0:
            process.serve(left)


class ScaledClock:
    """A time that goes faster or slower than the wall's; messages bear it.

    Attributes:
        begin: The time of the system's clock at its 0, in s.
        rtf: How many seconds of it pass in a second of the wall's.
    """

    def __init__(self, rtf: float, begin: float | None = None) -> None:
        """Start the clock.

        Args:
            rtf: How many seconds of it pass in a second.
            begin: The time of the system's clock at its 0, in s; now by default.
        """
        self.begin = time.time() if begin is None else begin
        self.rtf = rtf
        # Asked once: setting the system's clock changes nothing later.
        self._offset = time.monotonic() - (time.time() - self.begin)
        ros_time.now_ns = lambda: round(self.now() * 1e9)

    def now(self) -> float:
        """Return the time."""
        return (time.monotonic() - self._offset) * self.rtf

    def wait_until(self, t: float, process: RosProcess) -> None:
        """Serve a process until a time has come, or it is to stop; at least once."""
        process.serve((t - self.now()) / self.rtf)
        while not process.stopping and (left := t - self.now()) > 0.0:
            process.serve(left / self.rtf)
