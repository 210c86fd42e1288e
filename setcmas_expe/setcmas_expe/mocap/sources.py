"""Sources of poses: topics and messages of motion capture drivers, their readers, the presets."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.planar_pose import Pose, yaw_of_quaternion
from setcmas_simu.fleet.topics import TF
from setcmas_simu.plugins import InvalidPluginError, PluginGroup


@dataclass(frozen=True)
class Sample:
    """One measurement by a driver.

    Attributes:
        position: x, y, z in m.
        orientation: Quaternion x, y, z, w.
        stamp: Time of the measurement on the driver's clock in s; 0 if not set.
    """

    position: tuple[float, float, float]
    orientation: tuple[float, float, float, float]
    stamp: float = 0.0

    def z_up(self) -> Sample:
        """Return a measurement in Y-up axes (of world and body) in Z-up axes.

        A quarter turn about x takes (x, y, z), and the vector part of a quaternion, to (x, -z, y).
        """
        x, y, z = self.position
        qx, qy, qz, qw = self.orientation
        return replace(self, position=(x, -z, y), orientation=(qx, -qz, qy, qw))

    def planar(self) -> Pose:
        """Return x, y in m and the heading in rad."""
        return (*self.position[:2], yaw_of_quaternion(*self.orientation))


Read = Callable[[Any], Iterator[tuple[str, Sample]]]
"""Yields name and measurement of each rigid body in a message."""

POSE_STAMPED = 'PoseStamped'
ODOMETRY = 'Odometry'
TRANSFORM_STAMPED = 'TransformStamped'


def sample_of(header: Any, position: Any, orientation: Any) -> Sample:
    """Return a measurement from the parts of a message, whatever its frame_id."""
    from setcmas_simu.ros.messages import seconds_of  # late: sources are named without ROS, too

    p, q = position, orientation
    return Sample((p.x, p.y, p.z), (q.x, q.y, q.z, q.w), seconds_of(header.stamp))


def read_pose_stamped(message: Any) -> Iterator[tuple[str, Sample]]:
    """Read a geometry_msgs/PoseStamped."""
    yield '', sample_of(message.header, message.pose.position, message.pose.orientation)


def read_transform_stamped(message: Any) -> Iterator[tuple[str, Sample]]:
    """Read a geometry_msgs/TransformStamped."""
    transform = message.transform
    yield '', sample_of(message.header, transform.translation, transform.rotation)


def read_odometry(message: Any) -> Iterator[tuple[str, Sample]]:
    """Read the pose in a nav_msgs/Odometry: drivers send velocities in different axes, or none."""
    pose = message.pose.pose
    yield '', sample_of(message.header, pose.position, pose.orientation)


STANDARD: dict[str, tuple[str, Read]] = {
    POSE_STAMPED: ('geometry_msgs/msg/PoseStamped', read_pose_stamped),
    ODOMETRY: ('nav_msgs/msg/Odometry', read_odometry),
    TRANSFORM_STAMPED: ('geometry_msgs/msg/TransformStamped', read_transform_stamped),
}
"""Types that a lab file may name, and their readers."""

NAME = '{name}'
"""Placeholder for the name of a rigid body in a topic."""

CUSTOM = 'custom'
"""The preset of any other driver: the lab file sets topic and type."""

_TOPIC = re.compile(r'(/[A-Za-z0-9_]+)+')
_BODY = re.compile(r'[A-Za-z][A-Za-z0-9_]*')


@dataclass(frozen=True)
class MocapSource:
    """A motion capture driver: the topics and messages in which it sends rigid bodies.

    Attributes:
        topic: Full name of the topic: with {name}, each body has its own; without, one topic
            serves all bodies.
        message_type: Type of the messages, such as 'geometry_msgs/msg/PoseStamped'.
        read: Yields name and measurement of each body in a message, in the driver's axes; the
            name is empty where each body has its topic.
        shared: Whether other nodes may send on the topic, which hides a second driver.
        driver: Name and version of the driver; empty if unknown.
        from_start: Whether poses count from where a robot was switched on, so that the lab file
            must give its start pose.
    """

    topic: str
    message_type: str
    read: Read
    shared: bool = False
    driver: str = ''
    from_start: bool = False

    @property
    def per_body(self) -> bool:
        """Whether each body has a topic of its own."""
        return NAME in self.topic

    def topic_of(self, body: str) -> str:
        """Return the topic of a body."""
        return self.topic.replace(NAME, body)

    def bodies_in(self, topics: Iterable[str]) -> list[str]:
        """Return the bodies, sorted, whose own topic is among these."""
        first, *again = map(re.escape, self.topic.split(NAME))
        form = f'{first}({_BODY.pattern})' + r'\1'.join(again)
        found = (re.fullmatch(form, topic) for topic in topics)
        return sorted(match[1] for match in found if match)

    def samples(self, body: str, message: Any) -> list[tuple[str, Sample]]:
        """Return bodies and their measurements in a message on the topic of `body`."""
        return [(body if self.per_body else name, one) for name, one in self.read(message)]

    def message_class(self) -> Any:
        """Return the class of the messages; SetcmasError if its package is not installed."""
        from setcmas_simu.ros.messages import NoPythonTypeError, message_class  # needs ROS

        try:
            return message_class(self.message_type)
        except NoPythonTypeError:
            package = self.message_type.partition('/')[0]
            raise SetcmasError(
                f'motion capture sends {self.message_type}, whose package is not installed: '
                f'sudo apt install ros-jazzy-{package.replace("_", "-")}, and source ROS'
            ) from None

    @property
    def body_must_be(self) -> str:
        """The rule that `may_name` applies, for messages."""
        if not self.per_body:
            return 'a name'
        return (
            'a name of letters, digits and _ that begins with a letter, such as tb3_1: it is part '
            'of a topic of ROS 2 (rename the body in the motion capture system)'
        )

    def may_name(self, body: str) -> bool:
        """Return whether a body may have this name."""
        return bool(_BODY.fullmatch(body)) if self.per_body else bool(body)


def check_topic(topic: str, per_body: bool) -> str:
    """Return the topic of a source.

    Raises:
        SetcmasError: It is not the full name of a topic, or {name} is missing or not wanted.
    """
    if (NAME in topic) != per_body or not _TOPIC.fullmatch(topic.replace(NAME, 'a')):
        wanted = f'with {NAME} for the rigid body, such as /vrpn_mocap/{NAME}/pose'
        raise SetcmasError(
            f"topic '{topic}' must be the full name of a topic "
            + (wanted if per_body else 'of all bodies, such as /poses')
        )
    return topic


def per_body(topic: str, kind: str, driver: str = '', from_start: bool = False) -> MocapSource:
    """Return a source with a topic per body; `kind` is a standard type such as PoseStamped."""
    return MocapSource(topic, *STANDARD[kind], driver=driver, from_start=from_start)


def checked_source(thing: object) -> MocapSource:
    """Return a plugin as a source, or raise InvalidPluginError."""
    if not isinstance(thing, MocapSource):
        raise InvalidPluginError(f'it is a {type(thing).__name__}; it must be a MocapSource')
    try:
        check_topic(thing.topic, thing.per_body)
    except SetcmasError as error:
        raise InvalidPluginError(str(error)) from None
    if not re.fullmatch(r'\w+/msg/\w+', thing.message_type):
        raise InvalidPluginError(
            f"type '{thing.message_type}' must be like geometry_msgs/msg/Pose"
        )
    return thing


MOCAP_SOURCES = PluginGroup('setcmas.mocap_sources', 'mocap source', checked_source)
"""The drivers that a lab file may name, except `custom`."""

QUALISYS = per_body(
    '/qualisys/{name}/odom', ODOMETRY, 'motion_capture_system (KumarRobotics, KTH-SML), for ROS 1'
)
VRPN = per_body('/vrpn_mocap/{name}/pose', POSE_STAMPED, 'vrpn_mocap 1.1.0 and 1.2.0')
OPTITRACK = per_body(
    '/{name}/pose', POSE_STAMPED, 'mocap_optitrack 1.1.0, topics by its mocap.yaml'
)
NATNET = per_body('/{name}/pose', POSE_STAMPED, 'natnet_ros2 (L2S-lab), commit 3e3f8d3')
NOKOV = per_body('/{name}/pose', POSE_STAMPED, 'not verified')
VICON = per_body(
    '/vicon/{name}/{name}', POSE_STAMPED, 'vicon_receiver 0.1.1 (ros2-vicon-receiver)'
)
CAMERA = per_body('/camera/{name}/pose', POSE_STAMPED, 'setcmas camera')
WHEEL_ODOMETRY = per_body(
    '/{name}/odom', ODOMETRY, 'turtlebot3_node, from start poses in the lab file', from_start=True
)


def _read_all(bodies: str, name: str) -> Read:
    """Return a reader of messages with one header and a list of named poses."""

    def read(message: Any) -> Iterator[tuple[str, Sample]]:
        for body in getattr(message, bodies):
            pose = body.pose
            yield getattr(body, name), sample_of(message.header, pose.position, pose.orientation)

    return read


MOCAP4R2 = MocapSource(
    '/rigid_bodies',
    'mocap4r2_msgs/msg/RigidBodies',
    _read_all('rigidbodies', 'rigid_body_name'),
    driver='mocap4ros2_optitrack, _qualisys, _nokov (mocap4r2_msgs)',
)
MOTION_CAPTURE_TRACKING = MocapSource(
    '/poses',
    'motion_capture_tracking_interfaces/msg/NamedPoseArray',
    _read_all('poses', 'name'),
    driver='motion_capture_tracking 1.0.9',
)


def read_transforms(message: Any) -> Iterator[tuple[str, Sample]]:
    """Read a tf2_msgs/TFMessage; bodies are child frames, whatever the parents."""
    for one in message.transforms:
        pose = one.transform
        yield one.child_frame_id, sample_of(one.header, pose.translation, pose.rotation)


TRANSFORMS = MocapSource(
    TF,
    'tf2_msgs/msg/TFMessage',
    read_transforms,
    shared=True,
    driver='any; tf2_msgs must be installed',
)
