"""The ROS interface of a simulated robot: cmd_vel in; odometry, pose, marker and transform out."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, PoseStamped, TransformStamped, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import Empty
from visualization_msgs.msg import Marker

from setcmas_simu.fleet import topics
from setcmas_simu.fleet.palettes import colour
from setcmas_simu.fleet.topics import TF, WORLD_FRAME, robot_name, robot_topic
from setcmas_simu.options.kinds import Number
from setcmas_simu.robots.model import Shape
from setcmas_simu.robots.models import shape_of
from setcmas_simu.robots.unicycle import BURGER_SHAPE
from setcmas_simu.robots.virtual_fleet import Command
from setcmas_simu.ros import messages, qos
from setcmas_simu.ros.cmd_vel_topics import TYPES
from setcmas_simu.ros.messages import Location
from setcmas_simu.ros.parameters import declare_fixed
from setcmas_simu.ros.polling import PolledTopic

_EDGE = 0.09  # m: two by two cubes are about as wide and high as a Burger
_BODY = [(0.0, side * _EDGE / 2, _EDGE * level) for side in (-1, 1) for level in (0.5, 1.5)]
_NOSE = (0.07, 0.0, 0.5 * _EDGE)  # shows the heading
_PLACE = Number(least=-1e6, most=1e6)  # m, rad: finite
_POSE = ('x0', 'y0', 'theta0')
START = {
    **dict(zip(_POSE, ('x at the start in m', 'y in m', 'heading in rad'), strict=True)),
    'model': 'robot model',
    'robot_frame': 'frame of the robot',
}
"""Parameters of a robot's start, with their descriptions."""

_Corner = tuple[float, float, float]


def robot_marker(robot: int, frame_id: str = WORLD_FRAME, shape: Shape = BURGER_SHAPE) -> Marker:
    """Return the marker of a robot, still without stamp and pose."""
    red, green, blue = colour(robot)
    marker = Marker(ns=robot_name(robot), id=robot, action=Marker.ADD)
    marker.header.frame_id = frame_id
    marker.color.r, marker.color.g, marker.color.b, marker.color.a = red, green, blue, 1.0
    if shape is BURGER_SHAPE:  # five cubes cost less than triangles, ten times a second
        marker.type, corners, size = Marker.CUBE_LIST, [*_BODY, _NOSE], _EDGE
    else:
        marker.type, corners, size = Marker.TRIANGLE_LIST, list(_triangles(shape)), 1.0
    marker.scale.x = marker.scale.y = marker.scale.z = size
    marker.points = [Point(x=x, y=y, z=z) for x, y, z in corners]
    return marker


def _triangles(shape: Shape) -> Iterator[_Corner]:
    """Yield the corners in m of the triangles of a body's top and walls, three per triangle."""
    low = [(x, y, 0.0) for x, y in shape.body]
    high = [(x, y, shape.height) for x, y in shape.body]
    for i in range(1, len(high) - 1):
        yield from (high[0], high[i], high[i + 1])
    for i, corner in enumerate(high):
        before = i - 1
        yield from (low[before], low[i], corner)
        yield from (low[before], corner, high[before])


try:
    from tf2_msgs.msg import TFMessage
except ImportError:  # no wheel exists
    TFMessage = None


class FleetTransforms:
    """Publishes the transforms of all robots of a process in one message."""

    def __init__(self, node: Node, frames: list[tuple[str, str]]) -> None:
        self._publisher = None
        if TFMessage is None:
            return
        self._message = TFMessage()
        for parent, child in frames:
            transform = TransformStamped(child_frame_id=child)
            transform.header.frame_id = parent
            self._message.transforms.append(transform)
        self._publisher = node.create_publisher(TFMessage, TF, qos.EVENT)

    def publish(self, stamp: Time, locations: Sequence[Location]) -> None:
        """Publish the locations of the robots in the order of the frames."""
        if self._publisher is None:
            return
        for transform, (x, y, z, w) in zip(self._message.transforms, locations, strict=True):
            transform.header.stamp = stamp
            transform.transform.translation.x, transform.transform.translation.y = x, y
            transform.transform.rotation.z, transform.transform.rotation.w = z, w
        self._publisher.publish(self._message)


OnCommand = Callable[[Command], None]


class VirtualRobot:
    """ROS interface of one simulated robot; a FleetStepper moves it.

    Attributes:
        commanded: Stamp of its newest command in ns; NO_STAMP without one.
        pose: Start pose, x and y in m and heading in rad.
        frames: World frame, and frame of the robot.
    """

    def __init__(
        self,
        node: Node,
        robot: int,
        start: Mapping[str, Any],
        cmd_vel_type: str,
        profile: QoSProfile = qos.STATE,
        prefix: str = '',
    ) -> None:
        """Create the topics of a robot, and fixed parameters with its values in `start`.

        Their names are those in `START` after a prefix, and `--ros-args` overrides them; `start`
        also has the `world_frame`. Raises SetcmasError for an invalid value.
        """
        self.robot = robot
        self.commanded = messages.NO_STAMP
        self.on_command: OnCommand = lambda _: None
        self.on_reset: Callable[[], None] = lambda: None
        values = {
            name: declare_fixed(node, f'{prefix}{name}', start[name], text)
            for name, text in START.items()
        }
        for name in _POSE:
            _PLACE.check(f'parameter {prefix}{name}', values[name])
        self.pose = [values[name] for name in _POSE]
        self.model = str(values['model'])
        self.frames = str(start['world_frame']), str(values['robot_frame'])
        topic = partial(robot_topic, robot)
        self._odom_publisher = node.create_publisher(Odometry, topic(topics.ODOM), profile)
        self._pose_publisher = node.create_publisher(PoseStamped, topic(topics.POSE), profile)
        self._marker_publisher = node.create_publisher(Marker, topic(topics.MARKER), profile)
        self._kind = TYPES[cmd_vel_type]
        self.commands = PolledTopic(
            node, self._kind, topic(topics.CMD_VEL), self._on_cmd_vel, qos.COMMAND, encoded=True
        )
        self._resets = PolledTopic(
            node, Empty, topic(topics.RESET), lambda _: self.on_reset(), qos.EVENT
        )
        world, frame = self.frames
        odom, pose = Odometry(child_frame_id=frame), PoseStamped()
        odom.header.frame_id = pose.header.frame_id = world
        marker = robot_marker(robot, world, shape_of(self.model))
        self._odom = _Located(odom, 'pose.pose')
        self._write_twist = self._odom.place('twist.twist.linear.x', messages.TWIST)
        self._pose, self._marker = _Located(pose, 'pose'), _Located(marker, 'pose')

    def take(self) -> None:
        """Take the newest command, then resets, which override it."""
        self.commands.take()
        self._resets.take()

    def publish_odometry(self, stamp: Time, location: Location, twist: Command) -> None:
        """Publish location and velocities (m/s, rad/s) of the robot."""
        V, left, omega = twist
        self._write_twist(V, left, 0.0, 0.0, 0.0, omega)
        self._odom_publisher.publish(self._odom.at(stamp, location))

    def publish_picture(self, stamp: Time, location: Location) -> None:
        """Publish the robot's pose for displays, and its marker."""
        self._pose_publisher.publish(self._pose.at(stamp, location))
        self._marker_publisher.publish(self._marker.at(stamp, location))

    def _on_cmd_vel(self, data: bytes) -> None:
        if self._kind is TwistStamped:
            self.commanded = messages.read_stamp(data)
        self.on_command(messages.read_twist(data, self._kind))


class _Located(messages.PreparedMessage):
    """An encoded message with the robot's pose."""

    def __init__(self, message: Any, pose: str) -> None:
        super().__init__(message)
        self._write_stamp = self.place('header.stamp.sec', messages.STAMP)
        self._write_pose = self.place(f'{pose}.position.x', messages.POSE)

    def at(self, stamp: Time, location: Location) -> bytes:
        """Return the message for a location."""
        self._write_stamp(stamp.sec, stamp.nanosec)
        x, y, z, w = location
        self._write_pose(x, y, 0.0, 0.0, 0.0, z, w)
        return self.encoded()
