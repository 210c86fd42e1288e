"""Topic /clock, for nodes with use_sim_time."""

from __future__ import annotations

from builtin_interfaces.msg import Time
from rclpy.node import Node
from rosgraph_msgs.msg import Clock

from setcmas_simu.fleet import topics
from setcmas_simu.ros import qos


class ClockTopic:
    """Publishes the time of a simulation."""

    def __init__(self, node: Node) -> None:
        """Create the publisher on a node."""
        self._publisher = node.create_publisher(Clock, topics.CLOCK, qos.LOCKSTEP_STATE)

    def publish(self, stamp: Time) -> None:
        """Publish a time."""
        self._publisher.publish(Clock(clock=stamp))
