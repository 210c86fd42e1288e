"""The two message types of cmd_vel: a TurtleBot3 on Jazzy takes one, on Humble the other."""

from __future__ import annotations

from geometry_msgs.msg import Twist, TwistStamped
from rclpy.node import Node

from setcmas_simu import topics

TYPES = {'twist_stamped': TwistStamped, 'twist': Twist}
"""Message classes by the name that options give them."""

ROS_NAMES = {
    'geometry_msgs/msg/TwistStamped': 'twist_stamped',
    'geometry_msgs/msg/Twist': 'twist',
}
"""Names in options by the type's name on the ROS graph."""


def cmd_vel_listeners(node: Node, topic: str) -> list[tuple[str, str]]:
    """Return the names of the nodes that listen to commands, bystanders aside, and the types."""
    return [
        (info.node_name, ROS_NAMES[info.topic_type])
        for info in node.get_subscriptions_info_by_topic(topic)
        if info.node_name not in topics.BYSTANDER_NODES and info.topic_type in ROS_NAMES
    ]


def types_of_robot(node: Node, listeners: list[tuple[str, str]], odometry_topic: str) -> set[str]:
    """Return the types that a robot takes: where listeners differ, the one with odometry is it."""
    senders = {info.node_name for info in node.get_publishers_info_by_topic(odometry_topic)}
    robot = {kind for name, kind in listeners if name in senders}
    return robot or {kind for _, kind in listeners}


def velocities(message: Twist | TwistStamped) -> tuple[float, float]:
    """Return forward speed (m/s) and turn rate (rad/s) of a command of either type."""
    twist = message.twist if isinstance(message, TwistStamped) else message
    return twist.linear.x, twist.angular.z
