"""Velocity commands: their message types, publishers and subscribers in the ROS graph."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Twist, TwistStamped
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.topic_endpoint_info import TopicEndpointInfo

from setcmas_simu.fleet import topics
from setcmas_simu.fleet.topics import AUTO, CMD_VEL_TYPES
from setcmas_simu.ros import messages, qos
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.messages import CutShortError, SerializedMessage

TYPES = {'twist_stamped': TwistStamped, 'twist': Twist}
"""Message classes by their name in options."""

ROS_NAMES = {'geometry_msgs/msg/TwistStamped': 'twist_stamped', 'geometry_msgs/msg/Twist': 'twist'}
"""Names in options by ROS type name."""


Command = tuple[float, float, float]
"""Speeds forward and to the left in m/s, and turn rate in rad/s."""


def velocities(message: Twist | TwistStamped) -> tuple[float, float]:
    """Return forward speed (m/s) and turn rate (rad/s) of a command of either type."""
    twist = message.twist if isinstance(message, TwistStamped) else message
    return twist.linear.x, twist.angular.z


def newest_command(node: FleetNode, kind: str) -> Callable[[], Command | None]:
    """Subscribe to the commands of a node's robot; kind is 'twist' or 'twist_stamped'.

    Returns:
        A function that returns the newest command since its last call: speeds forward and to the
        left in m/s, turn rate in rad/s. It returns None if none has come, or one cut short.
    """
    newest = node.newest(TYPES[kind], topics.CMD_VEL, qos.COMMAND, raw=True)

    def take() -> Command | None:
        message = newest()
        return _command_in(message, TYPES[kind] is TwistStamped) if message else None

    return take


def _command_in(message: bytes, has_header: bool) -> Command | None:
    try:
        fields = SerializedMessage(message)
        if has_header:
            fields.skip_header()
        V, left, _, _, _, omega = fields.reals(6)
    except CutShortError:
        return None
    return V, left, omega


KILLED = 'a killed one is listed for up to 20 s'
"""Why more publishers may be found than there are: the default lease of Fast DDS."""

_GUID_PREFIX = 12  # bytes of an endpoint's GUID that identify its participant (DDSI-RTPS 9.3)

_NO_NAME = ('_UNKNOWN_', '_BARE_DDS_APP_')  # what rmw reports for a node without a name
NAMELESS = 'a node without a name'
NAMED_AFTER_S = 0.2
"""Time in s within which the name of a ROS node becomes known; its publishers are seen first."""


@dataclass(frozen=True)
class Endpoint:
    """A publisher or a subscription of a topic.

    Attributes:
        name: Full name of its node; `NAMELESS` if it is not known yet, or there is no such node.
        kind: 'twist', 'twist_stamped', or a full ROS type name.
        participant: Its process.
    """

    name: str
    kind: str
    participant: bytes


class NameWait:
    """Waits for the name of a node that has just been found, so that a person reads who it is."""

    def __init__(self) -> None:
        self._since = math.inf

    def is_on(self, names: Collection[str], now: float, longest_s: float = NAMED_AFTER_S) -> bool:
        """Return whether one of these `rivals` may still get a name; now is in s."""
        if NAMELESS not in names:
            self._since = math.inf
            return False
        self._since = min(self._since, now)
        return now - self._since < longest_s


def publishers(node: Node, topic: str) -> list[Endpoint]:
    """Return the publishers of a topic (full name)."""
    return [_endpoint(info) for info in node.get_publishers_info_by_topic(topic)]


def participants(node: Node, topic: str) -> set[bytes]:
    """Return the processes that publish a topic (full name)."""
    return {endpoint.participant for endpoint in publishers(node, topic)}


def listeners(node: Node, topic: str) -> list[Endpoint]:
    """Return the subscriptions to a command topic, except those of recorders."""
    found = map(_endpoint, node.get_subscriptions_info_by_topic(topic))
    recorders = topics.RECORDER_NODES
    return [endpoint for endpoint in found if endpoint.name.rpartition('/')[2] not in recorders]


def types_of_robot(node: Node, found: list[Endpoint], odometry_topic: str) -> set[str]:
    """Return the message types that a robot accepts; the sender of its odometry decides."""
    wanted = {endpoint.kind for endpoint in found if endpoint.kind in TYPES}
    if len(wanted) <= 1:
        return wanted
    robot = participants(node, odometry_topic)
    kinds = {
        endpoint.kind
        for endpoint in found
        if endpoint.participant in robot and endpoint.kind in TYPES
    }
    return kinds or wanted


def twins(node: Node, topic: str) -> bool:
    """Return whether several robots with the same number listen to a command topic.

    Their nodes share one full name in the robot's namespace; other listeners rarely do.
    """
    namespace = topic.removesuffix(topics.CMD_VEL)
    found = {(endpoint.name, endpoint.participant) for endpoint in listeners(node, topic)}
    names = Counter(name for name, _ in found if name.startswith(namespace))
    return max(names.values(), default=0) > 1


def contest(node: Node, topic: str, found: Sequence[str]) -> str:
    """Return which of the found `rivals` commands a robot, or that several robots listen.

    It is empty if there is neither.
    """
    if found:
        return f'{found[0]} also commands it'
    return f'several robots listen to {topic}' if twins(node, topic) else ''


def rivals(node: Node, topic: str, *allowed: str) -> list[str]:
    """Return the names of a topic's publishers, but one of each full name that may publish."""
    names = Counter(one.name for one in publishers(node, topic))
    return list((names - Counter(allowed)).elements())


def _endpoint(info: TopicEndpointInfo) -> Endpoint:
    name = f'{info.node_namespace.rstrip("/")}/{info.node_name}'
    return Endpoint(
        NAMELESS if any(mark in name for mark in _NO_NAME) else name,
        ROS_NAMES.get(info.topic_type, info.topic_type),
        bytes(info.endpoint_gid[:_GUID_PREFIX]),
    )


def type_name(kind: str) -> str:
    """Return the name of a message class by its name in options; other names stay."""
    return TYPES[kind].__name__ if kind in TYPES else kind


_PREFERRED_TYPE = CMD_VEL_TYPES[0]


class CmdVelPublisher:
    """Commands one robot on a topic, whose full name is `topic`, by a `publisher`.

    `mixed` reports a listener that takes another type than the published one; None without one.
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

        `odometry_topic` is published by the robot itself, and shows which listener is its own.
        `cmd_vel_type` is 'twist', 'twist_stamped', or 'auto' for the type that the robot expects.
        """
        self.mixed: str | None = None
        self._node = node
        self._frame = topics.robot_frame(robot)
        self.topic = topic
        self._odometry_topic = odometry_topic
        self._auto = cmd_vel_type == AUTO
        self._type = _PREFERRED_TYPE if self._auto else cmd_vel_type
        self._profile = profile
        self._create_publisher()

    def publish(
        self, V: float, omega: float, left: float = 0.0, stamp: Time | None = None
    ) -> None:
        """Publish forward speed (m/s), turn rate (rad/s) and speed to the left (m/s).

        `stamp` is the time of the command; by default that of the system.
        """
        message = twist = self._message
        if isinstance(message, TwistStamped):
            message.header.stamp = stamp or messages.stamp()
            twist = message.twist
        twist.linear.x, twist.linear.y, twist.angular.z = V, left, omega
        self.publisher.publish(message)

    def follow_listeners(self) -> bool:
        """Match the type to what the robot listens to; return False if nothing listens."""
        found = listeners(self._node, self.topic)
        wanted = types_of_robot(self._node, found, self._odometry_topic)
        if self._auto and wanted:
            self._use_type(wanted)
        others = [node for node in found if node.kind != self._type]
        self.mixed = None
        if others:
            own, other = type_name(self._type), type_name(others[0].kind)
            topic = self.publisher.topic_name
            self.mixed = f'{topic} carries {own}, but {others[0].name} takes {other}'
        return any(endpoint.kind == self._type for endpoint in found)

    def _use_type(self, wanted: set[str]) -> None:
        if self._type not in wanted:
            # A listener of the former type would keep its last command for ever.
            self.publish(0.0, 0.0)
            self._type = _PREFERRED_TYPE if _PREFERRED_TYPE in wanted else wanted.pop()
            # One type at a time: within a process DDS knows only one type per topic.
            self._node.destroy_publisher(self.publisher)
            self._create_publisher()

    def _create_publisher(self) -> None:
        kind = TYPES[self._type]
        self.publisher = self._node.create_publisher(kind, self.topic, self._profile)
        self.topic = self.publisher.topic_name
        self._message = kind()
        if isinstance(self._message, TwistStamped):
            self._message.header.frame_id = self._frame
