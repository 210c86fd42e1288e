"""Topic /fleet_time: t, shared among controller processes."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable

from builtin_interfaces.msg import Time
from rclpy.node import Node
from sensor_msgs.msg import TimeReference

from setcmas_ctrl.fleet.fleet_time import FleetTime
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.ros import qos, ros_time
from setcmas_simu.ros.process import RosProcess

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
            message.header.stamp = ros_time.stamp()
            self._publisher.publish(message)

    def _on_time(self, message: TimeReference) -> None:
        if message.source != self._source:
            t = message.time_ref.sec + message.time_ref.nanosec / _NANOSECONDS
            self._time.hear(t, self._now())
