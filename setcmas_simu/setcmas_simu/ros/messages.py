"""Messages: encoded numbers (CDR) read and written in place, and stamps."""

from __future__ import annotations

import math
import struct
import time
from collections.abc import Callable
from typing import NamedTuple

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message, serialize_message

STAMP = '=iI'
"""Format of builtin_interfaces/Time: s and ns."""

NO_STAMP = -1
"""In place of a stamp in ns: nothing was sent."""

POSE = '=7d'
"""Format of geometry_msgs/Pose: position in m, quaternion."""

TWIST = '=6d'
"""Format of geometry_msgs/Twist: velocities in m/s, turn rates in rad/s."""

_OURS = serialize_message(Twist())[:2]  # the encoding of this machine
_ORIGIN = 4  # bytes of the header of the encoding, from which on fields are aligned
_STAMP_SIZE = 8
_LENGTH = struct.Struct('=I')
_POSE = struct.Struct(POSE)
_TWIST = struct.Struct(TWIST)
_COVARIANCE_SIZE = 36 * 8


class EncodedOdometry(NamedTuple):
    """Fields of an odometry: position (m), quaternion, forward speed (m/s), turn rate (rad/s)."""

    position: tuple[float, float]
    quaternion: tuple[float, float, float, float]
    V: float
    omega: float

    @property
    def fault(self) -> str:
        """Why the pose cannot be used; '' if it can."""
        x, y, z, w = self.quaternion
        norm = x * x + y * y + z * z + w * w
        if not math.isfinite(sum(self.position) + norm):
            return 'its pose is NaN or infinite'
        return '' if norm else 'its orientation is a zero quaternion'


def read_stamp(data: bytes) -> int:
    """Return the time in ns at the start of an encoded message, such as its header's."""
    seconds, nanoseconds = struct.unpack_from(
        '<iI' if data[1:2] == b'\1' else '>iI', data, _ORIGIN
    )
    return int(seconds) * 10**9 + int(nanoseconds)


def read_odometry(data: bytes) -> EncodedOdometry:
    """Return the pose and speeds of an encoded nav_msgs/Odometry."""
    data = _in_our_encoding(data, Odometry)
    at = _after_texts(data, 2)
    x, y, _, *quaternion = _POSE.unpack_from(data, at)
    twist = _TWIST.unpack_from(data, at + _POSE.size + _COVARIANCE_SIZE)
    return EncodedOdometry((x, y), tuple(quaternion), twist[0], twist[5])


def read_twist(data: bytes, kind: type) -> tuple[float, float, float]:
    """Return speeds forward and left (m/s) and turn rate (rad/s) of an encoded command."""
    data = _in_our_encoding(data, kind)
    at = _after_texts(data, 1) if kind is TwistStamped else _ORIGIN
    twist = _TWIST.unpack_from(data, at)
    return twist[0], twist[1], twist[5]


def _in_our_encoding(data: bytes, kind: type) -> bytes:
    return data if data[:2] == _OURS else serialize_message(deserialize_message(data, kind))


def _after_texts(data: bytes, nb_texts: int) -> int:
    """Return where 8-byte numbers begin after a stamp and some strings."""
    at = _ORIGIN + _STAMP_SIZE
    for _ in range(nb_texts):
        at += -at % 4
        at += _LENGTH.size + _LENGTH.unpack_from(data, at)[0]
    return at + (_ORIGIN - at) % 8


now_ns: Callable[[], int] = time.time_ns
"""Returns the time in ns; a process that follows a simulation replaces it."""


def stamp() -> Time:
    """Return the current time."""
    seconds, nanoseconds = divmod(now_ns(), 10**9)
    return Time(sec=seconds, nanosec=nanoseconds)
