"""Transforms of odometry, serialised: what tf2 would publish, without its message package."""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import NamedTuple

from setcmas_simu.fleet.topics import WORLD_FRAME

_LITTLE_ENDIAN = b'\0\1\0\0'  # the header of plain CDR
_HEADER = len(_LITTLE_ENDIAN)
_STAMP = 8  # bytes: seconds and nanoseconds
_POSE = 56  # bytes: position and orientation, which a Transform has in the same order
_ORIGIN = struct.pack('<7d', 0, 0, 0, 0, 0, 0, 1)
_BASE_LINK_HEIGHT_M = 0.01  # base_joint in turtlebot3_burger.urdf


class Transform(NamedTuple):
    """A geometry_msgs/TransformStamped, its numbers as bytes of CDR.

    Attributes:
        stamp: Its time.
        parent: Frame in which the pose is.
        child: Frame whose pose it is.
        pose: Translation (m) and quaternion x, y, z, w.
    """

    stamp: bytes
    parent: str
    child: str
    pose: bytes


def transform_of(odometry: bytes) -> Transform | None:
    """Return the transform that a serialised Odometry tells; None unless it is in the world."""
    if odometry[:_HEADER] != _LITTLE_ENDIAN:
        return None
    parent, at = _text(odometry, _HEADER + _STAMP)
    child, at = _text(odometry, at)
    at = _aligned(at, 8)
    pose = odometry[at : at + _POSE]
    if parent != WORLD_FRAME or not child or len(pose) < _POSE:
        return None
    return Transform(odometry[_HEADER : _HEADER + _STAMP], parent, child, pose)


def base_link_of(transform: Transform) -> Transform | None:
    """Return where the base_link is in a base_footprint, which stays so; None for other frames."""
    robot, slash, frame = transform.child.rpartition('/')
    if frame != 'base_footprint':
        return None
    pose = struct.pack('<d', 0) * 2 + struct.pack('<d', _BASE_LINK_HEIGHT_M) + _ORIGIN[24:]
    return Transform(transform.stamp, transform.child, f'{robot}{slash}base_link', pose)


def tf_message(transforms: Iterable[Transform]) -> bytes:
    """Return a serialised tf2_msgs/TFMessage."""
    listed = list(transforms)
    data = bytearray(_LITTLE_ENDIAN + struct.pack('<I', len(listed)))
    for transform in listed:
        _pad(data, 4)
        data += transform.stamp
        for frame in (transform.parent, transform.child):
            _pad(data, 4)
            text = frame.encode() + b'\0'
            data += struct.pack('<I', len(text)) + text
        _pad(data, 8)
        data += transform.pose
    return bytes(data)


def _text(data: bytes, at: int) -> tuple[str, int]:
    """Return the text that begins at an offset, or after it, and the offset of its end."""
    at = _aligned(at, 4)
    if len(data) < at + 4:
        return '', at
    (length,) = struct.unpack_from('<I', data, at)
    end = at + 4 + length
    return data[at + 4 : end - 1].decode(errors='replace'), end


def _aligned(at: int, size: int) -> int:
    """Return the first offset from `at` on that is aligned; CDR counts from its header's end."""
    return at + (_HEADER - at) % size


def _pad(data: bytearray, size: int) -> None:
    data += bytes((_HEADER - len(data)) % size)
