"""Messages: encoded numbers (CDR) read and written in place, and stamps."""

from __future__ import annotations

import json
import math
import struct
import time
import zlib
from array import array
from collections.abc import Callable, Mapping, Sequence
from operator import attrgetter
from typing import Any, NamedTuple

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

_ORIGIN = 4  # bytes of the header of the encoding, from which on fields are aligned
_HEADER = serialize_message(Twist())[:_ORIGIN]
_OURS = _HEADER[:2]  # the encoding of this machine
_STAMP_SIZE = 8
_LENGTH = struct.Struct('=I')
_STAMP = struct.Struct(STAMP)
_POSE = struct.Struct(POSE)
_TWIST = struct.Struct(TWIST)
_POINT = struct.Struct(f'={_ORIGIN}s3f')
_COVARIANCE_SIZE = 36 * 8
_MOST_FORMS = 2**24  # bytes that foreign nodes can make this process unpack
_NOT_FORMS = (
    zlib.error, struct.error, TypeError, AttributeError, IndexError, RecursionError,
)  # fmt: skip
_MARKS = {'d': 1.2345678901234567e89, 'i': 0x5A3C_96E1}

State = Sequence[float]
"""x and y in m, z and w of the quaternion, speeds forward and left in m/s, turn rate in rad/s."""


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


class LocatedMessage:
    """An encoded message with stamp, and pose or velocities of a robot, or both."""

    def __init__(
        self, data: bytes, stamp: int, pose: int | None = None, twist: int | None = None
    ) -> None:
        """Take an encoded message, and where in it stamp, pose and velocities begin."""
        self._data = bytearray(data)
        self._places = stamp, pose, twist

    @classmethod
    def of(cls, message: Any, pose: str = '', twist: str = '') -> LocatedMessage:
        """Return the form of a message whose header has the stamp, by the names of its fields."""
        return cls(
            serialize_message(message),
            _offset(message, 'header.stamp.sec', 'i'),
            _offset(message, f'{pose}.position.x', 'd') if pose else None,
            _offset(message, f'{twist}.linear.x', 'd') if twist else None,
        )

    @property
    def form(self) -> list[Any]:
        """Its arguments, for JSON."""
        return [self._data.hex(), *self._places]

    def at(self, stamp_ns: int, state: State) -> bytes:
        """Return the message for a time in ns and a state."""
        stamp, pose, twist = self._places
        x, y, z, w, V, left, omega = state
        _STAMP.pack_into(self._data, stamp, *divmod(stamp_ns, 10**9))
        if pose is not None:
            _POSE.pack_into(self._data, pose, x, y, 0.0, 0.0, 0.0, z, w)
        if twist is not None:
            _TWIST.pack_into(self._data, twist, V, left, 0.0, 0.0, 0.0, omega)
        return bytes(self._data)


def encode_point(x: float, y: float, z: float) -> bytes:
    """Return an encoded geometry_msgs/Point32."""
    return _POINT.pack(_HEADER, x, y, z)


def _offset(message: Any, field: str, kind: str) -> int:
    """Return where in the encoded message a field of a `struct` format begins."""
    owner, _, name = field.rpartition('.')
    holder = attrgetter(owner)(message)
    value = getattr(holder, name)
    setattr(holder, name, _MARKS[kind])
    offset = serialize_message(message).index(struct.pack(f'={kind}', _MARKS[kind]))
    setattr(holder, name, value)
    return offset


def encode_forms(forms: Mapping[str, LocatedMessage]) -> array[int]:
    """Return messages, by full names of topics, as compressed JSON."""
    text = json.dumps({name: message.form for name, message in forms.items()})
    return array('B', zlib.compress(text.encode()))


def decode_forms(data: array[int]) -> dict[str, LocatedMessage]:
    """Return the messages in `encode_forms`, by full names of topics.

    Raises:
        ValueError: There are none, or states do not fit into one.
    """
    try:
        text = zlib.decompressobj().decompress(data, _MOST_FORMS)
        forms = {
            name: LocatedMessage(bytes.fromhex(text), *places)
            for name, (text, *places) in json.loads(text).items()
        }
        for form in forms.values():
            form.at(0, [0.0] * 7)
    except _NOT_FORMS as error:
        raise ValueError(f'it has no forms of messages: {error}') from error
    if not forms:
        raise ValueError('it has no forms of messages')
    return forms


now_ns: Callable[[], int] = time.time_ns
"""Returns the time in ns; a process that follows a simulation replaces it."""


def stamp() -> Time:
    """Return the current time."""
    seconds, nanoseconds = divmod(now_ns(), 10**9)
    return Time(sec=seconds, nanosec=nanoseconds)
