"""Commands of the browser view's buttons to the fleet."""

from __future__ import annotations

from rclpy.node import Node
from rclpy.publisher import Publisher
from std_msgs.msg import Bool, Empty

from setcmas_simu.fleet import topics
from setcmas_simu.ros import qos


class FleetCommands:
    """Publishes pause, reset and emergency stop.

    The publishers are made when somebody can press the buttons: a topic on which nobody ever
    speaks would be found in every recorded run.
    """

    def __init__(self, node: Node) -> None:
        """Prepare; nothing is published before `prepare`."""
        self._node = node
        self._pause: Publisher | None = None
        self._reset: Publisher | None = None
        self._stop: Publisher | None = None
        self._listeners = 0

    def prepare(self) -> None:
        """Make the publishers, so that listeners know them when a button is pressed."""
        if self._pause is None:
            self._pause = self._node.create_publisher(Bool, topics.FLEET_PAUSE, qos.EVENT)
            self._reset = self._node.create_publisher(Empty, topics.FLEET_RESET, qos.EVENT)
            self._stop = self._node.create_publisher(Bool, topics.EMERGENCY_STOP, qos.EVENT)

    def pause(self, paused: bool) -> None:
        """Ask the robots to stand (True), or to go on."""
        if self._pause:
            self._pause.publish(Bool(data=paused))

    def stop(self) -> None:
        """Stop all robots at once, until an operator releases them."""
        if self._stop:
            self._stop.publish(Bool(data=True))

    def reset(self) -> None:
        """Put simulated robots back to their start poses."""
        if self._reset:
            self._reset.publish(Empty())

    def follow_listeners(self, paused: bool) -> None:
        """Tell controllers that have come since the last call of a pause that still holds."""
        if self._pause is None:
            return
        listeners = self._pause.get_subscription_count()
        if paused and listeners > self._listeners:
            self._pause.publish(Bool(data=True))
        self._listeners = listeners
