"""Clocks of the steps of nodes: in real time, in scaled time, and that of /clock."""

from __future__ import annotations

import time
from collections.abc import Sequence

from builtin_interfaces.msg import Time
from rclpy.node import Node
from rosgraph_msgs.msg import Clock

from setcmas_simu.fleet import topics
from setcmas_simu.ros import messages, qos
from setcmas_simu.ros.polling import PolledTopic
from setcmas_simu.ros.process import RosProcess


class SteadyClock:
    """Real time in s from any origin, independent of changes of the system clock."""

    rtf = 1.0
    """Real-time factor: seconds of this clock per second of real time."""

    topics: Sequence[PolledTopic] = ()
    """Topics that bring its time, if any, for the `RequestWait` of a process that waits by it."""

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


class TopicClock(SteadyClock):
    """Time on /clock, also in message stamps, for nodes with use_sim_time."""

    def __init__(self, node: Node) -> None:
        """Subscribe; the clock stands at 0 until the first message."""
        self._stamp_ns: int | None = None
        self._elapsed_ns = 0
        self._topic = PolledTopic(node, Clock, topics.CLOCK, self._on_clock, qos.CLOCK)
        self.topics = [self._topic]

    def has_begun(self) -> bool:
        """Return whether a message has come."""
        self._topic.take()
        return self._stamp_ns is not None

    def now(self) -> float:
        """Return the time since the first message, without steps back."""
        self._topic.take()
        return 1e-9 * self._elapsed_ns

    def stamp(self) -> Time:
        """Return the newest time, as the simulator sent it."""
        return messages.stamp_of(self._stamp_ns or 0)

    def _on_clock(self, message: Clock) -> None:
        stamp_ns = message.clock.sec * 10**9 + message.clock.nanosec
        if self._stamp_ns is not None:  # a restarted simulator begins again
            self._elapsed_ns += max(0, stamp_ns - self._stamp_ns)
        self._stamp_ns = stamp_ns
