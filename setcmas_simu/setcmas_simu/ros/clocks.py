"""Clocks of the steps of nodes: in real or scaled time."""

from __future__ import annotations

import time

from builtin_interfaces.msg import Time

from setcmas_simu.ros import messages
from setcmas_simu.ros.process import RosProcess


class SteadyClock:
    """Real time in s from any origin, independent of changes of the system clock."""

    rtf = 1.0
    """Real-time factor: seconds of this clock per second of real time."""

    def now(self) -> float:
        """Return the time."""
        return time.monotonic()

    def stamp(self) -> Time:
        """Return the current time for the headers of messages."""
        return messages.stamp()

    def wait_until(self, t: float, process: RosProcess) -> None:
        """Serve a process until a time or a stop request; at least one callback."""
        process.serve((t - self.now()) / self.rtf)
        while not process.stopping and (left := t - self.now()) > 0.0:
            process.serve(left / self.rtf)


class ScaledClock(SteadyClock):
    """Time that runs faster or slower than real time, also in message stamps."""

    def __init__(self, rtf: float, begin: float | None = None) -> None:
        """Start the clock; its time 0 is at `begin` (s) of the system clock, by default now."""
        self.begin = time.time() if begin is None else begin
        self.rtf = rtf
        # Read once: later changes of the system clock have no effect.
        self._offset = time.monotonic() - (time.time() - self.begin)

    def now(self) -> float:
        """Return the time."""
        return (time.monotonic() - self._offset) * self.rtf

    def stamp(self) -> Time:
        """Return the current time for the headers of messages."""
        return messages.stamp_of(round(self.now() * 1e9))
