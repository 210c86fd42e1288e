"""The two message types of cmd_vel: a TurtleBot3 on Jazzy takes one, on Humble the other."""

from __future__ import annotations

from geometry_msgs.msg import Twist, TwistStamped

from setcmas_simu.ros import ros_time

TYPES = {'twist_stamped': TwistStamped, 'twist': Twist}
"""Message classes by their name in options."""

ROS_NAMES = {
    'geometry_msgs/msg/TwistStamped': 'twist_stamped',
    'geometry_msgs/msg/Twist': 'twist',
}
"""Names in options by ROS type name."""


def velocities(message: Twist | TwistStamped) -> tuple[float, float]:
    """Return forward speed (m/s) and turn rate (rad/s) of a command of either type."""
    twist = message.twist if isinstance(message, TwistStamped) else message
    return twist.linear.x, twist.angular.z


def command(kind: str, V: float, omega: float, left: float, frame: str) -> Twist | TwistStamped:
    """Return a command: forward speed (m/s), turn rate (rad/s), speed to the left (m/s)."""
    message = TYPES[kind]()
    twist = message
    if isinstance(message, TwistStamped):
        message.header.stamp = ros_time.stamp()
        message.header.frame_id = frame
        twist = message.twist
    twist.linear.x, twist.linear.y, twist.angular.z = V, left, omega
    return message
