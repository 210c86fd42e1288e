"""Time t of a run, the same for all controllers of a fleet."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable

from builtin_interfaces.msg import Time
from rclpy.node import Node
from sensor_msgs.msg import TimeReference

from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.ros import messages, qos
from setcmas_simu.ros.process import RosProcess

_SAME_S = 0.02  # between machines, a message takes some of it
_RECENT_S = 1.0


class FleetTime:
    """Begins at 0 with the first process, and never goes back; who comes later joins.

    Processes tell each other their t, and who hears of a later one takes it over. A message takes
    time, so that what is heard is never ahead of its sender: no two of them can push each other
    on, and the clocks of the machines need not agree. All times `now` are of one clock, in s.
    """

    def __init__(self) -> None:
        """Wait for the first step."""
        self._zero: float | None = None  # when t was 0, had it never been held
        self._stepped = 0.0
        self._held = False
        self._heard_zero = 0.0
        self._heard_at = -float('inf')
        self._is_clocks = False

    def at(self, now: float) -> float:
        """Return t, in s: 0 before the first step, and what it was then since a held one."""
        if self._zero is None:
            return 0.0
        return (self._stepped if self._held else now) - self._zero

    def step(self, now: float, held: bool) -> float:
        """Go on to a step, in which t stands still if it is held; return t."""
        if self._zero is None:
            self._zero = self._heard_zero if self.is_shared(now) else now
        elif held:
            self._zero += now - self._stepped
        self._stepped, self._held = now, held
        return now - self._zero

    def hear(self, t: float, now: float) -> None:
        """Take what another process says that t is."""
        if self._is_clocks:
            return
        self._heard_zero, self._heard_at = now - t, now
        if self._zero is not None and (lead := t - self.at(now)) > _SAME_S:
            self._zero -= lead

    def follow_clock(self) -> None:
        """Let t be the time of the clock: other processes have the same one."""
        self._zero, self._is_clocks = 0.0, True

    def is_shared(self, now: float) -> bool:
        """Return whether another process was heard of lately."""
        return now - self._heard_at < _RECENT_S

    def begin_anew(self) -> None:
        """Let t begin with the next step: at 0, or where that of the other processes is."""
        self._zero = None


_NANOSECONDS = 1_000_000_000
_OTHERS_WAIT_S = 1.0  # DDS finds processes one after another


class FleetTimeTopic:
    """Tells others the t of this process, and hears theirs."""

    def __init__(
        self, node: Node, robots: list[int], fleet_time: FleetTime, now: Callable[[], float]
    ) -> None:
        """Listen.

        Args:
            node: Holds publisher and subscription.
            robots: Numbers of the robots of this process.
            fleet_time: The t that is told, and moved by what is heard.
            now: Returns the time of the clock that it follows, in s.
        """
        self._node = node
        self._time = fleet_time
        self._now = now
        host = socket.gethostname()
        self._source = f'{robots_in_words(robots)} (process {os.getpid()} on {host})'
        self._publisher = node.create_publisher(TimeReference, topics.FLEET_TIME, qos.EVENT)
        # Called back, not polled: it is the time of its arrival that counts.
        node.create_subscription(TimeReference, topics.FLEET_TIME, self._on_time, qos.EVENT)

    def wait_for_others(self, process: RosProcess) -> None:
        """Wait until t is heard of another process; not for long, as there may be none."""
        process.spin_until(lambda: self._time.is_shared(self._now()), _OTHERS_WAIT_S)

    def tell(self) -> None:
        """Tell what t is now, if anybody listens."""
        if self._publisher.get_subscription_count() > 1:  # one is of this process
            t = self._time.at(self._now())
            sec, nanosec = divmod(round(t * _NANOSECONDS), _NANOSECONDS)
            message = TimeReference(time_ref=Time(sec=sec, nanosec=nanosec), source=self._source)
            message.header.stamp = messages.stamp()
            self._publisher.publish(message)

    def _on_time(self, message: TimeReference) -> None:
        if message.source != self._source:
            t = message.time_ref.sec + message.time_ref.nanosec / _NANOSECONDS
            self._time.hear(t, self._now())
