"""The node that turns a wanted velocity (cmd_cart_vel) into a unicycle's command (cmd_vel)."""

from __future__ import annotations

from geometry_msgs.msg import Point32, TwistStamped
from rclpy.duration import Duration
from rclpy.publisher import Publisher
from std_msgs.msg import Bool

from setcmas_ctrl.control_options import AUTO
from setcmas_ctrl.nodes.fleet_odometry import FleetOdometry
from setcmas_ctrl.si_to_uni import si_to_uni
from setcmas_simu import topics
from setcmas_simu.nodes import qos
from setcmas_simu.nodes.cmd_vel_type import ROS_NAMES, TYPES
from setcmas_simu.nodes.ros_process import FleetNode
from setcmas_simu.simulation_options import CMD_VEL_TYPES

NODE_NAME = 'si_to_uni'
_PREFERRED_TYPE = CMD_VEL_TYPES[0]
_LAST_WORDS_S = 0.3


class SiToUni(FleetNode):
    """Commands one robot; zero while it is paused, and when the process ends."""

    def __init__(
        self, robot: int, odometry: FleetOdometry, komega: float, cmd_vel_type: str = AUTO
    ) -> None:
        """Create the node in the robot's namespace.

        Args:
            robot: Number of the robot.
            odometry: Where its heading is read.
            komega: Gain on the heading error in 1/s.
            cmd_vel_type: 'twist', 'twist_stamped', or 'auto' for what the robot listens to.
        """
        super().__init__(NODE_NAME, namespace=topics.robot_name(robot))
        self.robot = robot
        self.paused = False
        self.mixed: str | None = None
        """Which listeners want another type than the one that is published; None if none."""
        self._odometry = odometry
        self._komega = komega
        self._auto = cmd_vel_type == AUTO
        self._type = _PREFERRED_TYPE if self._auto else cmd_vel_type
        self._cmd_vel = self._create_publisher()
        silent = {'event_callbacks': qos.no_subscription_events()}
        self.create_subscription(
            Point32, topics.CMD_CART_VEL, self._on_wanted_velocity, qos.COMMAND, **silent
        )
        self.create_subscription(
            Bool, topics.PAUSE, lambda message: self.pause(message.data), qos.EVENT, **silent
        )

    def pause(self, paused: bool) -> None:
        """Hold the robot at zero velocity, or let it go on."""
        self.paused = paused
        if paused:
            self.command(0.0, 0.0)

    def command(self, V: float, omega: float) -> None:
        """Publish a forward speed (m/s) and a turn rate (rad/s)."""
        message = TYPES[self._type]()
        twist = message
        if isinstance(message, TwistStamped):
            message.header.stamp = self.get_clock().now().to_msg()
            message.header.frame_id = topics.robot_name(self.robot)
            twist = message.twist
        twist.linear.x, twist.angular.z = V, omega
        self._cmd_vel.publish(message)

    def stop(self) -> None:
        """Command zero; called while the process ends."""
        self.command(0.0, 0.0)

    def wait_until_sent(self) -> None:
        """Wait, but not for long, until the last command has arrived."""
        self._cmd_vel.wait_for_all_acked(Duration(seconds=_LAST_WORDS_S))

    def follow_listeners(self) -> bool:
        """Match the type of cmd_vel to what the robot listens to; False if nothing listens."""
        listeners = self._listeners()
        if self._auto and listeners:
            # Where listeners differ, the node that sends the odometry is the robot.
            topic = topics.robot_topic(self.robot, topics.ODOM)
            robot = {i.node_name for i in self.get_publishers_info_by_topic(topic)}
            wanted = {kind for node, kind in listeners if node in robot}
            self._use_type(wanted or {kind for _, kind in listeners})
        others = [f'{node} wants {kind}' for node, kind in listeners if kind != self._type]
        name = topics.robot_name(self.robot)
        self.mixed = f'{name} gets {self._type}, but {others[0]}' if others else None
        return any(kind == self._type for _, kind in listeners)

    def _listeners(self) -> list[tuple[str, str]]:
        """Return the names of the nodes that listen to cmd_vel, recorders aside, and the types."""
        topic = topics.robot_topic(self.robot, topics.CMD_VEL)
        return [
            (info.node_name, ROS_NAMES[info.topic_type])
            for info in self.get_subscriptions_info_by_topic(topic)
            if info.node_name not in topics.RECORDER_NODES and info.topic_type in ROS_NAMES
        ]

    def _use_type(self, wanted: set[str]) -> None:
        if self._type not in wanted:
            self._type = _PREFERRED_TYPE if _PREFERRED_TYPE in wanted else wanted.pop()
            # One type at a time: DDS knows only one type of a topic within a process.
            self.destroy_publisher(self._cmd_vel)
            self._cmd_vel = self._create_publisher()

    def is_recorded(self) -> bool:
        """Return whether a recorder listens to the robot's commands."""
        topic = topics.robot_topic(self.robot, topics.CMD_VEL)
        listeners = self.get_subscriptions_info_by_topic(topic)
        return any(info.node_name in topics.RECORDER_NODES for info in listeners)

    def other_commanders(self) -> list[str]:
        """Return the full names of other nodes that publish the robot's cmd_vel."""
        topic = topics.robot_topic(self.robot, topics.CMD_VEL)
        own = f'/{topics.robot_name(self.robot)}/{NODE_NAME}'
        names = [
            f'{info.node_namespace.rstrip("/")}/{info.node_name}'
            for info in self.get_publishers_info_by_topic(topic)
        ]
        if own in names:
            names.remove(own)
        return [name for name in names if 'UNKNOWN' not in name]  # not all is known of it yet

    def _create_publisher(self) -> Publisher:
        return self.create_publisher(
            TYPES[self._type],
            topics.CMD_VEL,
            qos.COMMAND,
            event_callbacks=qos.no_publisher_events(),
        )

    def _on_wanted_velocity(self, message: Point32) -> None:
        if self.paused:
            self.command(0.0, 0.0)
            return
        theta = self._odometry.theta(self.robot)
        V, omega = si_to_uni((message.x, message.y), theta, self._komega)
        self.command(float(V), float(omega))
