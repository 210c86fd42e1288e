"""Sender of a topic that only one process may publish, such as a robot's wheel odometry."""

from __future__ import annotations

from rclpy.node import Node

from setcmas_simu.cmd_vel import cmd_vel_graph


class OnlySender:
    """Remembers the process that publishes a topic, to detect a second one.

    Attributes:
        process: The last process that was alone on the topic; empty before the first.
    """

    def __init__(self, node: Node, topic: str) -> None:
        """Watch a topic (full name) through a node."""
        self.process: set[bytes] = set()
        self._node = node
        self._topic = topic

    def impostor(self) -> str:
        """Return a message about a second publisher; '' if there is none."""
        found = cmd_vel_graph.participants(self._node, self._topic)
        if len(found) == 1:
            self.process = found
        others = cmd_vel_graph.strangers(self._node, self._topic, self.process)
        return (
            f'{others[0]} also publishes its wheel odometry' if len(found) > 1 and others else ''
        )
