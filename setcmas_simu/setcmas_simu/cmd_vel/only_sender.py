"""Sender of a topic that only one process may send, such as a robot's wheel odometry."""

from __future__ import annotations

from rclpy.node import Node

from setcmas_simu.cmd_vel import cmd_vel_graph


class OnlySender:
    """Pins the process that sends a topic: another one beside it is not believed.

    Attributes:
        process: The one that was alone last; empty if none ever was.
    """

    def __init__(self, node: Node, topic: str) -> None:
        """Look through a node; `topic` is the full name."""
        self.process: set[bytes] = set()
        self._node = node
        self._topic = topic

    def impostor(self) -> str:
        """Return who else sends it; empty if nobody."""
        found = cmd_vel_graph.participants(self._node, self._topic)
        if len(found) == 1:
            self.process = found
        others = cmd_vel_graph.strangers(self._node, self._topic, self.process)
        return f'{others[0]} sends its wheel odometry too' if len(found) > 1 and others else ''
