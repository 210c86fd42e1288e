"""The ROS interface of a simulated robot: cmd_vel in; odometry, pose, marker and transform out."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, PoseStamped, TransformStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
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
from setcmas_simu.ros.messages import LocatedMessage, State
from setcmas_simu.ros.parameters import declare_fixed
from setcmas_simu.ros.polling import OnDemandPublisher, PolledTopic

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

    def publish(self, stamp: Time, states: Sequence[State]) -> None:
        """Publish the poses of the robots in the order of the frames."""
        if self._publisher is None:
            return
        for transform, (x, y, z, w, *_) in zip(self._message.transforms, states, strict=True):
            transform.header.stamp = stamp
            transform.transform.translation.x, transform.transform.translation.y = x, y
            transform.transform.rotation.z, transform.transform.rotation.w = z, w
        self._publisher.publish(self._message)


_TOPICS = (topics.ODOM, topics.POSE, topics.MARKER)

OnCommand = Callable[[Command], None]


class VirtualRobot:
    """ROS interface of one simulated robot; a FleetStepper moves it.

    Attributes:
        pose: Start pose, x and y in m and heading in rad.
        frames: World frame, and frame of the robot.
        forms: Messages with its state, by full names of topics.
    """

    def __init__(
        self,
        node: Node,
        robot: int,
        start: Mapping[str, Any],
        cmd_vel_type: str,
        in_lockstep: bool = False,
        prefix: str = '',
    ) -> None:
        """Create the topics of a robot, and fixed parameters with its values in `start`.

        Their names are those in `START` after a prefix, and `--ros-args` overrides them; `start`
        also has the `world_frame`. Raises SetcmasError for an invalid value. In lockstep commands
        come with the answers of controllers, and messages are published on demand.
        """
        self.robot = robot
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
        self._commands: PolledTopic | None = None
        if not in_lockstep:
            kind = TYPES[cmd_vel_type]
            self._commands = PolledTopic(
                node,
                kind,
                topic(topics.CMD_VEL),
                lambda data: self.on_command(messages.read_twist(data, kind)),
                qos.COMMAND,
                encoded=True,
            )
        self._resets = PolledTopic(
            node, Empty, topic(topics.RESET), lambda _: self.on_reset(), qos.EVENT
        )
        self._messages = self._located()
        self.forms = dict(zip(map(topic, _TOPICS), self._messages, strict=True))
        profile = qos.LOCKSTEP_STATE if in_lockstep else qos.STATE
        publishers = [
            node.create_publisher(Odometry, topic(topics.ODOM), profile),
            node.create_publisher(PoseStamped, topic(topics.POSE), profile),
            node.create_publisher(Marker, topic(topics.MARKER), profile),
        ]
        self._publishers = [
            OnDemandPublisher(publishers[0], not in_lockstep),
            *map(OnDemandPublisher, publishers[1:]),
        ]

    def _located(self) -> list[LocatedMessage]:
        """Return the messages with its state, in the order of _TOPICS."""
        world, frame = self.frames
        odom, pose = Odometry(child_frame_id=frame), PoseStamped()
        odom.header.frame_id = pose.header.frame_id = world
        marker = robot_marker(self.robot, world, shape_of(self.model))
        return [
            LocatedMessage.of(odom, 'pose.pose', 'twist.twist'),
            LocatedMessage.of(pose, 'pose'),
            LocatedMessage.of(marker, 'pose'),
        ]

    def take(self) -> None:
        """Take the newest command, then resets, which override it."""
        if self._commands:
            self._commands.take()
        self._resets.take()

    def publish_odometry(self, stamp_ns: int, state: State) -> None:
        """Publish pose and velocities of the robot."""
        self._publish(0, stamp_ns, state)

    def publish_picture(self, stamp_ns: int, state: State) -> None:
        """Publish the robot's pose for displays, and its marker."""
        self._publish(1, stamp_ns, state)
        self._publish(2, stamp_ns, state)

    def publish_to_newcomers(self, stamp_ns: int, state: State) -> None:
        """Publish to those who have subscribed since the last step."""
        for i, publisher in enumerate(self._publishers):
            if publisher.has_newcomers:
                self._publish(i, stamp_ns, state)

    def _publish(self, i: int, stamp_ns: int, state: State) -> None:
        self._publishers[i].publish(lambda: self._messages[i].at(stamp_ns, state))
