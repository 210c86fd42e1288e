"""The topic /task: what the control laws of a process tell of their task, for recorders."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.node import Node
from std_msgs.msg import String

from setcmas_ctrl.control.control_law import ControlLaw
from setcmas_ctrl.task.references import told_references
from setcmas_simu.fleet import topics
from setcmas_simu.ros import qos


class TaskTopic:
    """Publishes the task and its references as JSON, latched."""

    def __init__(self, node: Node, nb_robots: int) -> None:
        """Publish through a node, for a fleet of nb_robots."""
        self._nb_robots = nb_robots
        self._warn = node.get_logger().warning
        self._publisher = node.create_publisher(String, topics.TASK, qos.LATCHED)

    def tell(self, laws: Sequence[ControlLaw]) -> None:
        """Publish what the first law tells that tells of a task; a mistake is a warning."""
        scripts = [(law.names, law.path) for law in laws]
        if references := told_references(scripts, self._nb_robots, self._warn):
            self._publisher.publish(String(data=references.encoded()))
