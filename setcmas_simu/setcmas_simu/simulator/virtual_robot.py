"""ROS interface of one virtual robot: cmd_vel in; odometry, pose and marker out."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any

from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, TwistStamped
from nav_msgs.msg import Odometry
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.qos import QoSProfile
from std_msgs.msg import Empty
from std_srvs.srv import Trigger
from visualization_msgs.msg import Marker

from setcmas_simu.cmd_vel.cmd_vel_type import TYPES
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.planar_pose import quaternion_of_yaw
from setcmas_simu.lockstep.answer import NONE
from setcmas_simu.messages.cdr import POSE, STAMP, TWIST, PreparedMessage, read_stamp, read_twist
from setcmas_simu.messages.polled_service import PolledService
from setcmas_simu.messages.polled_topic import PolledTopic
from setcmas_simu.robots.models import shape_of
from setcmas_simu.robots.virtual_fleet import Command
from setcmas_simu.ros import qos
from setcmas_simu.ros.process import FleetNode
from setcmas_simu.simulator.robot_marker import robot_marker

OnCommand = Callable[[Command], None]


class VirtualRobot(FleetNode):
    """ROS interface of one simulated robot; a FleetStepper moves it.

    Attributes:
        robot: Its number.
        commands: Topic of its commands.
        commanded: Stamp of its newest command in ns; NONE without one.

    Parameters: robot_no, x0, y0 (m), theta0 (rad), rate (Hz), world_frame, robot_frame, model,
    limits, cmd_timeout (s), cmd_vel_type.
    """

    def __init__(
        self, robot: int, defaults: dict[str, Any], profile: QoSProfile = qos.STATE
    ) -> None:
        """Create the node in the robot's namespace.

        Args:
            robot: Number of the robot.
            defaults: Parameter values that `--ros-args` overrides.
            profile: Quality of service of its states.
        """
        self.robot = robot
        self.commanded = NONE
        self.on_command: OnCommand = lambda _: None
        self.on_reset: Callable[[], None] = lambda: None

        super().__init__(topics.VIRTUAL_ROBOT_NODE, namespace=topics.robot_name(robot))
        # Dynamic typing: to ROS `-p x0:=2` is an integer, which must be accepted.
        dynamic = ParameterDescriptor(dynamic_typing=True)
        names = {'world_frame': topics.WORLD_FRAME, 'robot_frame': topics.robot_frame(robot)}
        for name, value in (names | defaults | {'robot_no': robot}).items():
            self.declare_parameter(name, value, dynamic)

        self._odom_publisher = self.create_publisher(Odometry, topics.ODOM, profile)
        self._pose_publisher = self.create_publisher(PoseStamped, topics.POSE, profile)
        self._marker_publisher = self.create_publisher(Marker, topics.MARKER, profile)
        self._kind = TYPES[self.choice('cmd_vel_type', TYPES)]
        self.commands = PolledTopic(
            self, self._kind, topics.CMD_VEL, self._on_cmd_vel, qos.COMMAND, encoded=True
        )
        self._resets = PolledTopic(self, Empty, topics.RESET, lambda _: self.on_reset(), qos.EVENT)

        self._offered: list[PolledService] = []
        world = str(self.value('world_frame'))
        odom = Odometry(child_frame_id=str(self.value('robot_frame')))
        pose = PoseStamped()
        odom.header.frame_id = pose.header.frame_id = world
        marker = robot_marker(robot, world, shape_of(str(self.value('model'))))
        self._odom = _Located(odom, 'pose.pose')
        self._write_twist = self._odom.place('twist.twist.linear.x', TWIST)
        self._pose, self._marker = _Located(pose, 'pose'), _Located(marker, 'pose')

    def offer_services(self) -> None:
        """Offer the service `~/reset`, the same as the topic but with a response."""
        self._offered.append(PolledService(self, Trigger, '~/reset', self._answer_reset))

    def value(self, name: str) -> Any:
        """Return the value of a parameter."""
        return self.get_parameter(name).value

    def number(self, name: str, least: float = -math.inf, most: float = math.inf) -> float:
        """Return the value of a numeric parameter.

        Raises:
            SetcmasError: The value is not a number between `least` and `most`.
        """
        value = self.value(name)
        numeric = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not numeric or not least <= value <= most:
            raise SetcmasError(
                f'parameter {name} is {value!r}; it must be from {least:g} to {most:g}'
            )
        return float(value)

    def choice(self, name: str, accepted: Iterable[str]) -> str:
        """Return the value of a parameter with a fixed set of values.

        Raises:
            SetcmasError: The value is not in the set.
        """
        value = self.value(name)
        if value not in accepted:
            raise SetcmasError(
                f'parameter {name} is {value!r}; it must be one of {", ".join(accepted)}'
            )
        return str(value)

    def take(self) -> None:
        """Take the newest command, then resets, which override it."""
        self.commands.take()
        self._resets.take()
        for service in self._offered:
            service.take()

    def publish_odometry(
        self, stamp: Time, pose: tuple[float, float, float], twist: Command
    ) -> None:
        """Publish pose (m, rad) and velocities (m/s, rad/s) of the robot."""
        V, left, omega = twist
        self._write_twist(V, left, 0.0, 0.0, 0.0, omega)
        self._odom_publisher.publish(self._odom.at(stamp, pose))

    def publish_picture(self, stamp: Time, pose: tuple[float, float, float]) -> None:
        """Publish the robot's pose (m, rad) for displays, and its marker."""
        self._pose_publisher.publish(self._pose.at(stamp, pose))
        self._marker_publisher.publish(self._marker.at(stamp, pose))

    def _answer_reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self.on_reset()
        response.success = True
        response.message = f'{topics.robot_name(self.robot)} is back at its start pose'
        return response

    def _on_cmd_vel(self, data: bytes) -> None:
        if self._kind is TwistStamped:
            self.commanded = read_stamp(data)
        self.on_command(read_twist(data, self._kind))


class _Located(PreparedMessage):
    """An encoded message with the robot's pose."""

    def __init__(self, message: Any, pose: str) -> None:
        """Encode a message with a header; `pose` names its pose field."""
        super().__init__(message)
        self._write_stamp = self.place('header.stamp.sec', STAMP)
        self._write_pose = self.place(f'{pose}.position.x', POSE)

    def at(self, stamp: Time, pose: tuple[float, float, float]) -> bytes:
        """Return the message for a pose (m, rad)."""
        self._write_stamp(stamp.sec, stamp.nanosec)
        x, y, theta = pose
        self._write_pose(x, y, 0.0, 0.0, 0.0, *quaternion_of_yaw(theta))
        return self.encoded()
