"""Time t of a run, the same for all controllers of a fleet."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from rclpy.node import Node

from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.ros import messages, qos
from setcmas_simu.ros.clocks import SteadyClock
from setcmas_simu.ros.polling import PolledTopic
from setcmas_simu.ros.process import RosProcess

if TYPE_CHECKING:
    from sensor_msgs.msg import TimeReference

_SAME_S = 0.02  # covers the travel time of messages between machines
_RECENT_S = 1.0


class FleetTime:
    """Starts at 0 in the first process and never goes back; later processes adopt it.

    Processes send each other their t, and each adopts a later t that it receives. Since messages
    take time, a received t is never ahead of its sender's: processes cannot push each other
    forward, and the machines' clocks need not agree. All times `now` are of one clock, in s.
    """

    def __init__(self) -> None:
        self._zero: float | None = None  # when t would have been 0 without pauses
        self._stepped = 0.0
        self._paused = False
        self._received_zero = 0.0
        self._received_at = -float('inf')

    def at(self, now: float) -> float:
        """Return t in s: 0 before the first step, and constant while paused."""
        if self._zero is None:
            return 0.0
        return (self._stepped if self._paused else now) - self._zero

    def step(self, now: float, paused: bool) -> float:
        """Advance t to this step, unless it is paused; return t.

        After a pause at the start, t of the first step is 0: laws test it.
        """
        if self._zero is None:
            if self.is_shared(now):
                self._zero = self._received_zero
            elif not paused:
                self._zero = now
        elif paused:
            self._zero += now - self._stepped
        self._stepped, self._paused = now, paused
        return self.at(now)

    def synchronise(self, t: float, now: float) -> None:
        """Adopt t of another process if it is later, unless that one has just begun."""
        if t <= _SAME_S:
            return
        self._received_zero, self._received_at = now - t, now
        if self._zero is not None and (lead := t - self.at(now)) > _SAME_S:
            self._zero -= lead

    def is_shared(self, now: float) -> bool:
        """Return whether another process has sent its t recently."""
        return now - self._received_at < _RECENT_S

    def begin_anew(self) -> None:
        """Start t again at the next step: at 0, or at the t of the other processes."""
        self._zero = None


_OTHERS_WAIT_S = 1.0  # DDS finds processes one after another


class FleetTimeTopic:
    """Publishes the t of this process, and receives that of others.

    Attributes:
        topic: Where it comes from; to be taken at once, as the time of arrival matters.
    """

    def __init__(
        self, node: Node, robots: list[int], fleet_time: FleetTime, clock: SteadyClock
    ) -> None:
        """Publish and synchronise a time, which runs by a clock."""
        from sensor_msgs.msg import TimeReference  # takes 0.01 s; rarely needed

        self._time = fleet_time
        self._clock = clock
        process = f'process {os.getpid()} on {os.uname().nodename}'
        self._message = TimeReference(source=f'{robots_in_words(robots)} ({process})')
        self._publisher = node.create_publisher(TimeReference, topics.FLEET_TIME, qos.EVENT)
        self.topic = PolledTopic(node, TimeReference, topics.FLEET_TIME, self._on_time, qos.EVENT)

    def wait_for_others(self, process: RosProcess) -> None:
        """Wait briefly for t of another process, if there is one."""
        process.spin_until(lambda: self._time.is_shared(self._clock.now()), _OTHERS_WAIT_S)

    def publish(self) -> None:
        """Publish the current t if another process listens."""
        if self._publisher.get_subscription_count() > 1:  # this process is one of them
            t = self._time.at(self._clock.now())
            self._message.time_ref = messages.stamp_of(round(1e9 * t))
            self._message.header.stamp = self._clock.stamp()
            self._publisher.publish(self._message)

    def _on_time(self, message: TimeReference) -> None:
        if message.source != self._message.source:
            self._time.synchronise(messages.seconds_of(message.time_ref), self._clock.now())
