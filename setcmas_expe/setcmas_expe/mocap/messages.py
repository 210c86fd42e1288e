"""Messages of motion capture drivers, read into samples."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

from setcmas_expe.mocap.sample import Sample

Read = Callable[[Any], Iterator[tuple[str, Sample]]]
"""Yields the name of each rigid body in a message, and what was measured of it."""

POSE_STAMPED = 'PoseStamped'
ODOMETRY = 'Odometry'
TRANSFORM_STAMPED = 'TransformStamped'


def sample_of(header: Any, position: Any, orientation: Any) -> Sample:
    """Return a measurement from the parts of a message; its frame_id is not trusted."""
    p, q = position, orientation
    stamp = header.stamp.sec + 1e-9 * header.stamp.nanosec
    return Sample((p.x, p.y, p.z), (q.x, q.y, q.z, q.w), stamp)


def read_pose_stamped(message: Any) -> Iterator[tuple[str, Sample]]:
    """Read a geometry_msgs/PoseStamped."""
    yield '', sample_of(message.header, message.pose.position, message.pose.orientation)


def read_transform_stamped(message: Any) -> Iterator[tuple[str, Sample]]:
    """Read a geometry_msgs/TransformStamped."""
    transform = message.transform
    yield '', sample_of(message.header, transform.translation, transform.rotation)


def read_odometry(message: Any) -> Iterator[tuple[str, Sample]]:
    """Read a nav_msgs/Odometry; velocities that the driver leaves at zero are not given."""
    pose, twist = message.pose.pose, message.twist.twist
    linear, angular = twist.linear, twist.angular
    velocities = (linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
    sample = sample_of(message.header, pose.position, pose.orientation)
    yield '', replace(sample, twist=velocities if any(velocities) else None)


STANDARD: dict[str, tuple[str, Read]] = {
    POSE_STAMPED: ('geometry_msgs/msg/PoseStamped', read_pose_stamped),
    ODOMETRY: ('nav_msgs/msg/Odometry', read_odometry),
    TRANSFORM_STAMPED: ('geometry_msgs/msg/TransformStamped', read_transform_stamped),
}
"""Types that a lab file may name, and how each is read."""
