"""Commanders and listeners of a robot, as the ROS graph tells."""

from __future__ import annotations

import uuid
from collections import Counter
from collections.abc import Collection
from dataclasses import dataclass

from rclpy.node import Node
from rclpy.topic_endpoint_info import TopicEndpointInfo
from std_msgs.msg import Empty

from setcmas_simu.cmd_vel.cmd_vel_type import ROS_NAMES, TYPES
from setcmas_simu.fleet import topics

_GUID_PREFIX = 12  # bytes of an endpoint's GUID that are those of its participant (DDSI-RTPS 9.3)

_NO_NAME = ('_UNKNOWN_', '_BARE_DDS_APP_')  # what rmw says in place of one


@dataclass(frozen=True)
class Endpoint:
    """A publisher or a subscription of a topic.

    Attributes:
        node: Base name of its node.
        full_name: The node's name with its namespace.
        kind: Its message type, by the name in options if it is one of these.
        gid: Identifies it in the whole network.
    """

    node: str
    full_name: str
    kind: str
    gid: bytes

    @property
    def participant(self) -> bytes:
        """What identifies its process."""
        return self.gid[:_GUID_PREFIX]

    @property
    def is_known(self) -> bool:
        """Whether the name of its node has arrived already; DDS without ROS has none."""
        return not any(mark in self.full_name for mark in _NO_NAME)


def publishers(node: Node, topic: str) -> list[Endpoint]:
    """Return who publishes a topic (full name)."""
    return [_endpoint(info) for info in node.get_publishers_info_by_topic(topic)]


def participants(node: Node, topic: str) -> set[bytes]:
    """Return the processes that publish a topic (full name)."""
    return {one.participant for one in publishers(node, topic)}


def own_participant(node: Node) -> bytes:
    """Return what identifies the process of a node, by a topic that nobody else can know of."""
    publisher = node.create_publisher(Empty, f'own_{uuid.uuid4().hex}', 1)
    (own,) = participants(node, publisher.topic_name)
    node.destroy_publisher(publisher)
    return own


def listeners(node: Node, topic: str) -> list[Endpoint]:
    """Return who listens to commands, recorders aside."""
    found = map(_endpoint, node.get_subscriptions_info_by_topic(topic))
    return [one for one in found if one.node not in topics.RECORDER_NODES]


def types_of_robot(node: Node, found: list[Endpoint], odometry_topic: str) -> set[str]:
    """Return the types that a robot takes: where listeners differ, who sends odometry is it."""
    wanted = {one.kind for one in found if one.kind in TYPES}
    if len(wanted) <= 1:
        return wanted
    robot = participants(node, odometry_topic)
    kinds = {one.kind for one in found if one.participant in robot and one.kind in TYPES}
    return kinds or wanted


def twins(node: Node, topic: str) -> bool:
    """Return whether several robots listen that were set up as the same one.

    Their nodes have one name, in the namespace of the robot; whoever looks on has it seldom.
    """
    namespace = topic.removesuffix(topics.CMD_VEL)
    found = {(one.full_name, one.participant) for one in listeners(node, topic)}
    names = Counter(name for name, _ in found if name.startswith(namespace))
    return max(names.values(), default=0) > 1


def commanders(node: Node, topic: str) -> list[str]:
    """Return the full names of the nodes that may command a simulated robot to move."""
    return [
        one.full_name
        for one in publishers(node, topic)
        if one.is_known and one.node != topics.STAND_IN_NODE
    ]


def rival(node: Node, topic: str, allowed: Collection[bytes]) -> str:
    """Return who else may move a robot, or move in its place; empty if nobody.

    Args:
        node: The node through which the graph is seen.
        topic: Full name of the robot's cmd_vel.
        allowed: The processes that may command it. Their nodes' names would prove nothing.
    """
    rivals = strangers(node, topic, allowed)
    if rivals:
        return f'{rivals[0]} commands it too'
    return f'several robots listen to {topic}' if twins(node, topic) else ''


def strangers(node: Node, topic: str, allowed: Collection[bytes]) -> list[str]:
    """Return what people call the publishers of a topic that are not of some processes."""
    return [
        one.full_name if one.is_known else 'a node without a name'
        for one in publishers(node, topic)
        if one.participant not in allowed
    ]


def _endpoint(info: TopicEndpointInfo) -> Endpoint:
    return Endpoint(
        info.node_name,
        f'{info.node_namespace.rstrip("/")}/{info.node_name}',
        ROS_NAMES.get(info.topic_type, info.topic_type),
        bytes(info.endpoint_gid),
    )
