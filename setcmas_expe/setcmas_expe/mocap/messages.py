"""Messages of motion capture drivers, of three types, as one."""

from __future__ import annotations

from geometry_msgs.msg import PoseStamped, TransformStamped
from nav_msgs.msg import Odometry

from setcmas_expe.mocap.sample import Sample
from setcmas_expe.mocap.sources import ODOMETRY, POSE_STAMPED, TRANSFORM_STAMPED

TYPES = {POSE_STAMPED: PoseStamped, ODOMETRY: Odometry, TRANSFORM_STAMPED: TransformStamped}
"""Message classes by the name that lab files give them."""


def sample_of(message: PoseStamped | Odometry | TransformStamped, y_up: bool) -> Sample:
    """Return what a message says, Z-up; its frame_id is not trusted."""
    twist = None
    if isinstance(message, TransformStamped):
        p, q = message.transform.translation, message.transform.rotation
    elif isinstance(message, Odometry):
        p, q = message.pose.pose.position, message.pose.pose.orientation
        twist = _twist_of(message, y_up)
    else:
        p, q = message.pose.position, message.pose.orientation
    stamp = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
    sample = Sample((p.x, p.y, p.z), (q.x, q.y, q.z, q.w), stamp, twist)
    return sample.z_up() if y_up else sample


def _twist_of(message: Odometry, y_up: bool) -> tuple[float, float, float, float] | None:
    """Return the velocities of an odometry; None where the driver leaves them at zero."""
    linear, angular = message.twist.twist.linear, message.twist.twist.angular
    turn = angular.y if y_up else angular.z
    twist = (linear.x, linear.y, linear.z, turn)
    return twist if any(twist) else None
