"""Encoded messages with the state of a robot: encoded once, then only their numbers change."""

from __future__ import annotations

import json
import struct
import zlib
from array import array
from collections.abc import Mapping, Sequence
from operator import attrgetter
from typing import Any

from rclpy.serialization import serialize_message

from setcmas_simu.ros.messages import POSE, STAMP, TWIST

_STAMP = struct.Struct(STAMP)
_POSE = struct.Struct(POSE)
_TWIST = struct.Struct(TWIST)
_MARKS = {'d': 1.2345678901234567e89, 'i': 0x5A3C_96E1}

State = Sequence[float]
"""x and y in m, z and w of the quaternion, speeds forward and left in m/s, turn rate in rad/s."""


class LocatedMessage:
    """An encoded message with stamp, pose and perhaps velocities of a robot."""

    def __init__(self, data: bytes, stamp: int, pose: int, twist: int | None = None) -> None:
        """Take an encoded message, and where in it stamp, pose and velocities begin."""
        self._data = bytearray(data)
        self._places = stamp, pose, twist

    @classmethod
    def of(cls, message: Any, pose: str, twist: str = '') -> LocatedMessage:
        """Return the form of a message whose header has the stamp, by the names of its fields."""
        return cls(
            serialize_message(message),
            _offset(message, 'header.stamp.sec', 'i'),
            _offset(message, f'{pose}.position.x', 'd'),
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
        _POSE.pack_into(self._data, pose, x, y, 0.0, 0.0, 0.0, z, w)
        if twist is not None:
            _TWIST.pack_into(self._data, twist, V, left, 0.0, 0.0, 0.0, omega)
        return bytes(self._data)


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
        ValueError: There are none.
    """
    try:
        return {
            name: LocatedMessage(bytes.fromhex(text), *places)
            for name, (text, *places) in json.loads(zlib.decompress(data)).items()
        }
    except (zlib.error, TypeError, AttributeError) as error:
        raise ValueError(f'it has no forms of messages: {error}') from error
