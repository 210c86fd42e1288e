"""Commanders and listeners of a robot, as the ROS graph tells."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from rclpy.node import Node
from rclpy.topic_endpoint_info import TopicEndpointInfo

from setcmas_simu.cmd_vel.cmd_vel_type import ROS_NAMES, TYPES
from setcmas_simu.fleet import topics

_GUID_PREFIX = 12  # bytes of an endpoint's GUID that are those of its participant (DDSI-RTPS 9.3)


@dataclass(frozen=True)
class Endpoint:
    """A publisher or a subscription of a robot's commands.

    Attributes:
        node: Base name of its node.
        full_name: The node's name with its namespace.
        kind: Its message type, by the name in options if it is one of these.
        participant: Identifies its process.
    """

    node: str
    full_name: str
    kind: str
    participant: bytes

    @property
    def is_known(self) -> bool:
        """Whether the name of its node has arrived already."""
        return 'UNKNOWN' not in self.full_name


def listeners(node: Node, topic: str) -> list[Endpoint]:
    """Return who listens to commands, bystanders aside."""
    found = map(_endpoint, node.get_subscriptions_info_by_topic(topic))
    return [one for one in found if one.node not in topics.BYSTANDER_NODES]


def types_of_robot(node: Node, found: list[Endpoint], odometry_topic: str) -> set[str]:
    """Return the types that a robot takes: where listeners differ, who sends odometry is it."""
    wanted = {one.kind for one in found if one.kind in TYPES}
    if len(wanted) <= 1:
        return wanted
    senders = node.get_publishers_info_by_topic(odometry_topic)
    robot = {_endpoint(sender).participant for sender in senders}
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
    """Return the full names of the nodes that may command a robot to move."""
    found = map(_endpoint, node.get_publishers_info_by_topic(topic))
    return [
        one.full_name for one in found if one.is_known and one.node not in topics.STOPPING_NODES
    ]


def rival(node: Node, topic: str, own: str = '') -> str:
    """Return who else may move a robot, or move in its place; empty if nobody.

    Args:
        node: The node through which the graph is seen.
        topic: Full name of the robot's cmd_vel.
        own: Full name of the node that commands it rightly.
    """
    rivals = commanders(node, topic)
    if own in rivals:
        rivals.remove(own)
    if rivals:
        return f'{rivals[0]} commands it too'
    return f'several robots listen to {topic}' if twins(node, topic) else ''


def is_guarded(node: Node, topic: str) -> bool:
    """Return whether a cmd_vel_guard stands by that speaks as the robot listens."""
    wanted = {one.kind for one in listeners(node, topic)}
    found = map(_endpoint, node.get_publishers_info_by_topic(topic))
    return any(one.node == topics.CMD_VEL_GUARD_NODE and one.kind in wanted for one in found)


def _endpoint(info: TopicEndpointInfo) -> Endpoint:
    return Endpoint(
        info.node_name,
        f'{info.node_namespace.rstrip("/")}/{info.node_name}',
        ROS_NAMES.get(info.topic_type, info.topic_type),
        bytes(info.endpoint_gid[:_GUID_PREFIX]),
    )
