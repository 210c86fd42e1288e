"""Commanders and listeners of a robot in the ROS graph."""

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

_GUID_PREFIX = 12  # bytes of an endpoint's GUID that identify its participant (DDSI-RTPS 9.3)

_NO_NAME = ('_UNKNOWN_', '_BARE_DDS_APP_')  # what rmw reports for a node without a name


@dataclass(frozen=True)
class Endpoint:
    """A publisher or a subscription of a topic.

    Attributes:
        node: Base name of its node.
        full_name: The node's name with its namespace.
        kind: Its message type: 'twist', 'twist_stamped', or the full ROS name.
        gid: Identifies it in the whole network.
    """

    node: str
    full_name: str
    kind: str
    gid: bytes

    @property
    def participant(self) -> bytes:
        """Identifier of its process."""
        return self.gid[:_GUID_PREFIX]

    @property
    def is_known(self) -> bool:
        """Whether the name of its node is known yet; DDS applications without ROS have none."""
        return not any(mark in self.full_name for mark in _NO_NAME)


def publishers(node: Node, topic: str) -> list[Endpoint]:
    """Return the publishers of a topic (full name)."""
    return [_endpoint(info) for info in node.get_publishers_info_by_topic(topic)]


def participants(node: Node, topic: str) -> set[bytes]:
    """Return the processes that publish a topic (full name)."""
    return {endpoint.participant for endpoint in publishers(node, topic)}


def own_participant(node: Node) -> bytes:
    """Return the identifier of a node's process, by publishing a topic with a unique name."""
    publisher = node.create_publisher(Empty, f'own_{uuid.uuid4().hex}', 1)
    (own,) = participants(node, publisher.topic_name)
    node.destroy_publisher(publisher)
    return own


def listeners(node: Node, topic: str) -> list[Endpoint]:
    """Return the subscriptions to a command topic, except those of recorders."""
    found = map(_endpoint, node.get_subscriptions_info_by_topic(topic))
    return [endpoint for endpoint in found if endpoint.node not in topics.RECORDER_NODES]


def types_of_robot(node: Node, found: list[Endpoint], odometry_topic: str) -> set[str]:
    """Return the message types that a robot accepts.

    If listeners differ, the process that sends the robot's odometry decides.
    """
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
    found = {(endpoint.full_name, endpoint.participant) for endpoint in listeners(node, topic)}
    names = Counter(name for name, _ in found if name.startswith(namespace))
    return max(names.values(), default=0) > 1


def commanders(node: Node, topic: str) -> list[str]:
    """Return the full names of the nodes that may command a simulated robot."""
    return [
        endpoint.full_name
        for endpoint in publishers(node, topic)
        if endpoint.is_known and endpoint.node != topics.STAND_IN_NODE
    ]


def rival(node: Node, topic: str, allowed: Collection[bytes]) -> str:
    """Return another process that commands the robot, or a second robot; '' if there is none.

    Args:
        node: Node through which to look at the ROS graph.
        topic: Full name of the robot's cmd_vel.
        allowed: Identifiers of the processes that may command it; node names can be forged.
    """
    rivals = strangers(node, topic, allowed)
    if rivals:
        return f'{rivals[0]} also commands it'
    return f'several robots listen to {topic}' if twins(node, topic) else ''


def strangers(node: Node, topic: str, allowed: Collection[bytes]) -> list[str]:
    """Return the names of a topic's publishers outside some processes."""
    return [
        endpoint.full_name if endpoint.is_known else 'a node without a name'
        for endpoint in publishers(node, topic)
        if endpoint.participant not in allowed
    ]


def _endpoint(info: TopicEndpointInfo) -> Endpoint:
    return Endpoint(
        info.node_name,
        f'{info.node_namespace.rstrip("/")}/{info.node_name}',
        ROS_NAMES.get(info.topic_type, info.topic_type),
        bytes(info.endpoint_gid),
    )
