"""Publisher of velocity commands with the message type that the robot listens to."""

from __future__ import annotations

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile

from setcmas_simu.cmd_vel import cmd_vel_graph
from setcmas_simu.cmd_vel.cmd_vel_type import TYPES, command
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.topics import AUTO, CMD_VEL_TYPES
from setcmas_simu.ros import qos

_PREFERRED_TYPE = CMD_VEL_TYPES[0]
_LAST_COMMAND_S = 0.3


class CmdVelPublisher:
    """Commands one robot.

    Attributes:
        topic: Full name of its topic.
        mixed: Which listener wants another type than the published one; None if none does.
    """

    def __init__(
        self,
        node: Node,
        robot: int,
        topic: str,
        odometry_topic: str,
        cmd_vel_type: str = AUTO,
        profile: QoSProfile = qos.COMMAND,
    ) -> None:
        """Create the publisher on a node.

        Args:
            node: The node.
            robot: Number of the robot.
            topic: Full name of the topic.
            odometry_topic: Topic that the robot itself publishes, to find its own listener.
            cmd_vel_type: 'twist', 'twist_stamped', or 'auto' for what the robot listens to.
            profile: Quality of service.
        """
        self.mixed: str | None = None
        self._node = node
        self._name = topics.robot_name(robot)
        self._frame = topics.robot_frame(robot)
        self.topic = topic
        self._odometry_topic = odometry_topic
        self._auto = cmd_vel_type == AUTO
        self._type = _PREFERRED_TYPE if self._auto else cmd_vel_type
        self._profile = profile
        self._publisher = self._create_publisher()

    def publish(self, V: float, omega: float, left: float = 0.0) -> None:
        """Publish forward speed (m/s), turn rate (rad/s) and speed to the left (m/s)."""
        self._publisher.publish(command(self._type, V, omega, left, self._frame))

    def wait_until_sent(self) -> None:
        """Wait briefly until the last command has arrived."""
        self._publisher.wait_for_all_acked(Duration(seconds=_LAST_COMMAND_S))

    def follow_listeners(self) -> bool:
        """Match the type to what the robot listens to; return False if nothing listens."""
        found = cmd_vel_graph.listeners(self._node, self.topic)
        wanted = cmd_vel_graph.types_of_robot(self._node, found, self._odometry_topic)
        if self._auto and wanted:
            self._use_type(wanted)
        others = [f'{node.node} wants {node.kind}' for node in found if node.kind != self._type]
        self.mixed = f'{self._name} gets {self._type}, but {others[0]}' if others else None
        return any(endpoint.kind == self._type for endpoint in found)

    def other_commanders(self) -> list[str]:
        """Return the full names of other nodes that command the robot."""
        names = cmd_vel_graph.commanders(self._node, self.topic)
        own = self._node.get_fully_qualified_name()
        if own in names:
            names.remove(own)
        return names

    def _use_type(self, wanted: set[str]) -> None:
        if self._type not in wanted:
            # A listener of the former type would keep its last command for ever.
            self.publish(0.0, 0.0)
            self._type = _PREFERRED_TYPE if _PREFERRED_TYPE in wanted else wanted.pop()
            # One type at a time: within a process DDS knows only one type per topic.
            self._node.destroy_publisher(self._publisher)
            self._publisher = self._create_publisher()

    def _create_publisher(self) -> Publisher:
        return self._node.create_publisher(
            TYPES[self._type],
            self.topic,
            self._profile,
        )
