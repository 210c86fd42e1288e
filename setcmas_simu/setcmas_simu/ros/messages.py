"""Messages: their classes by type, numbers in serialised ones, states of robots, stamps."""

from __future__ import annotations

import math
import struct
import time
from collections.abc import Iterable, Sequence
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


_ORDERS = {b'\x00\x00': '>', b'\x00\x01': '<'}  # CDR, big or little endian
_START = 4  # bytes before the first field, which tell the encoding


class CutShortError(Exception):
    """A message ends before a field, or is not encoded as CDR."""


class SerializedMessage:
    """Reads the fields of a message one after another, from the bytes that a subscription takes.

    They are encoded as CDR (OMG, DDS Interoperability Wire Protocol 2.2, section 10), where each
    number is aligned to its own size. rclpy would make 14 objects of an odometry, in 38 us instead
    of 5: with poses and commands read here, simulator and controllers of 50 robots take a sixth
    less processor time (benchmarks/fleet.py, 2 cores of an AMD EPYC). The package rosbags reads
    as fast, but takes 0.16 s to import.
    """

    def __init__(self, data: bytes) -> None:
        """Begin at the first field; raise CutShortError if the encoding is unknown."""
        if data[:2] not in _ORDERS:
            raise CutShortError
        self._order, self._fields, self._at = _ORDERS[data[:2]], data[_START:], 0

    def skip_header(self) -> None:
        """Skip a std_msgs/Header: the two numbers of its stamp, and a frame."""
        self._numbers(2, 'i', 4)
        self.skip_string()

    def skip_string(self) -> None:
        """Skip a string: its length, and so many bytes."""
        (length,) = self._numbers(1, 'I', 4)
        self._at += int(length)

    def reals(self, count: int) -> tuple[float, ...]:
        """Return numbers of type float64, or raise CutShortError."""
        return self._numbers(count, 'd', 8)

    def _numbers(self, count: int, kind: str, size: int) -> tuple[float, ...]:
        at = -(-self._at // size) * size
        self._at = at + count * size
        try:
            return struct.unpack_from(f'{self._order}{count}{kind}', self._fields, at)
        except struct.error as error:
            raise CutShortError from error


class RobotState(NamedTuple):
    """State of a robot: its pose, and its forward speed V in m/s."""

    pose: Pose
    V: float


def state_of(message: Odometry) -> RobotState | str:
    """Return the state in an odometry, or why its pose cannot be used."""
    place, turn = message.pose.pose.position, message.pose.pose.orientation
    V = message.twist.twist.linear.x
    return _checked_state(place.x, place.y, (turn.x, turn.y, turn.z, turn.w), V)


def state_in(odometry: bytes) -> RobotState | str:
    """Return the same for a serialised odometry."""
    try:
        fields = SerializedMessage(odometry)
        fields.skip_header()
        fields.skip_string()
        x, y, _, *turn = fields.reals(7)
        fields.reals(36)  # covariances
        V, *_ = fields.reals(6 + 36)  # the same of the twist: none of it may be missing
    except CutShortError:
        return 'it is cut short'
    return _checked_state(x, y, turn, V)


def _checked_state(x: float, y: float, turn: Sequence[float], V: float) -> RobotState | str:
    norm = sum(part * part for part in turn)
    if not math.isfinite(x + y + norm):
        return 'its pose is NaN or infinite'
    if not norm:
        return 'its orientation is a zero quaternion'
    return RobotState((x, y, float(yaw_of_quaternion(*turn))), V)


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
