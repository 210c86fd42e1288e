"""Messages: their classes by type, the state of a robot in an odometry, stamps, receipt."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable
from importlib import import_module
from typing import Any, NamedTuple

from builtin_interfaces.msg import Time
from nav_msgs.msg import Odometry
from rclpy.duration import Duration
from rclpy.publisher import Publisher

from setcmas_simu.fleet.planar_pose import Pose, quaternion_of_yaw, yaw_of_quaternion


class NoPythonTypeError(Exception):
    """The Python package of a message type is not installed."""


def message_class(msgtype: str) -> Any:
    """Return the class of a type such as `nav_msgs/msg/Odometry`, or raise NoPythonTypeError."""
    package, kind, name = msgtype.split('/')
    try:
        return getattr(import_module(f'{package}.{kind}'), name)
    except (ImportError, AttributeError) as error:
        raise NoPythonTypeError(f'no Python package {package} with it is installed') from error


class RobotState(NamedTuple):
    """State of a robot: pose, forward speed V in m/s, and its odometry."""

    pose: Pose
    V: float
    odometry: Odometry


def state_of(message: Odometry) -> RobotState | str:
    """Return the state in an odometry, or why its pose cannot be used."""
    place, turn = message.pose.pose.position, message.pose.pose.orientation
    norm = turn.x * turn.x + turn.y * turn.y + turn.z * turn.z + turn.w * turn.w
    if not math.isfinite(place.x + place.y + norm):
        return 'its pose is NaN or infinite'
    if not norm:
        return 'its orientation is a zero quaternion'
    theta = float(yaw_of_quaternion(turn.x, turn.y, turn.z, turn.w))
    return RobotState((place.x, place.y, theta), message.twist.twist.linear.x, message)


def fill_odometry(message: Odometry, pose: Pose, V: float, omega: float) -> None:
    """Write a pose, forward speed (m/s) and turn rate (rad/s) into an odometry."""
    message.pose.pose.position.x, message.pose.pose.position.y, theta = pose
    orientation = message.pose.pose.orientation
    orientation.z, orientation.w = quaternion_of_yaw(theta)
    message.twist.twist.linear.x, message.twist.twist.angular.z = V, omega


def stamp() -> Time:
    """Return the current time of the system."""
    return stamp_of(time.time_ns())


def stamp_of(time_ns: int) -> Time:
    """Return a time in ns as a stamp."""
    seconds, nanoseconds = divmod(time_ns, 10**9)
    return Time(sec=seconds, nanosec=nanoseconds)


def seconds_of(stamp: Time) -> float:
    """Return the time of a stamp in s."""
    return float(stamp.sec + stamp.nanosec / 1e9)


RECEIPT_S = 0.6
"""Longest wait for the receipt of last messages, in s."""


def wait_until_received(publishers: Iterable[Publisher], longest_s: float = RECEIPT_S) -> None:
    """Wait until the last messages of publishers have arrived, for at most a time in s in all."""
    deadline = time.monotonic() + longest_s
    for publisher in publishers:
        left = max(0.0, deadline - time.monotonic())
        publisher.wait_for_all_acked(Duration(seconds=left))
