"""Writer of a rosbag2 bag that stays readable when its recorder is killed."""

from __future__ import annotations

import contextlib
import struct
from collections.abc import Iterable, Sequence
from pathlib import Path
from types import TracebackType
from typing import Literal, NamedTuple, cast

from rclpy.qos import DurabilityPolicy, QoSProfile
from rosbags.interfaces import Connection, Qos
from rosbags.rosbag2 import StoragePlugin, Writer, WriterError
from rosbags.rosbag2.storage_mcap import McapWriter

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import TF, TF_STATIC, WORLD_FRAME
from setcmas_tools.bags.bag import DERIVED
from setcmas_tools.bags.message_types import Definition, MessageDefinitions
from setcmas_tools.bags.recorded_topic import stored_qos

_BAG_VERSION: Literal[9] = 9  # that of ROS 2 Jazzy


class BagWriter:
    """Writes serialised messages to an mcap bag; a context manager that closes it well.

    What is written becomes readable with each `flush`, whatever happens afterwards.

    Attributes:
        count: Number of messages written.
        start_ns: Time of the first message.
        end_ns: Time of the last message.
        types: Message types of the topics that have messages, by name.
    """

    def __init__(self, path: Path) -> None:
        """Create the folder of the bag.

        Raises:
            SetcmasError: It exists, or cannot be created.
        """
        self.path = path
        self.count = 0
        self.start_ns = 0
        self.end_ns = 0
        self._topics: dict[tuple[str, str], Connection] = {}
        self.types: dict[str, str] = {}
        try:
            self._writer = Writer(path, version=_BAG_VERSION, storage_plugin=StoragePlugin.MCAP)
            self._writer.open()
            self._write_out()
        except WriterError as error:
            raise SetcmasError(f"'{path}' exists already; it must be a new folder") from error
        except OSError as error:
            raise SetcmasError(f"bag '{path}' cannot be created: {error.strerror}") from error

    def add_topic(
        self, name: str, msgtype: str, definition: Definition, offered_qos: Sequence[Qos]
    ) -> Connection:
        """Add a topic unless it is there; what it returns stands for the topic in `write`.

        Args:
            name: Full name.
            msgtype: Type of its messages.
            definition: That of the type.
            offered_qos: Quality of service of each publisher, which a player repeats.
        """
        key = (name, msgtype)
        if key not in self._topics:
            self._topics[key] = self._writer.add_connection(
                name,
                msgtype,
                msgdef=definition.text,
                rihs01=definition.digest,
                offered_qos_profiles=offered_qos,
            )
        return self._topics[key]

    def write(self, topic: Connection, time_ns: int, data: bytes) -> None:
        """Write a message that was received at a time, not before that of the last one.

        Raises:
            OSError: The disk is full, or fails.
        """
        self._writer.write(topic, time_ns, data)
        self.types[topic.topic] = topic.msgtype
        self.start_ns = self.start_ns or time_ns
        self.end_ns = time_ns
        self.count += 1

    def flush(self) -> None:
        """Make all messages so far readable, even if this process is killed.

        Raises:
            OSError: The disk is full, or fails.
        """
        if self._storage.chunk.msgs:
            self._storage.close_chunk()
            self._write_out()

    def __str__(self) -> str:
        """Return what was written, such as '450 messages of 40 topics in 1.0 s'."""
        topics = len(self.types)
        return (
            f'{self.count:,} message{"s" * (self.count != 1)} of {topics} '
            f'topic{"s" * (topics != 1)} in {(self.end_ns - self.start_ns) / 1e9:.1f} s'
        )

    def __enter__(self) -> BagWriter:
        """Return the writer."""
        return self

    def __exit__(
        self,
        error_type: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Write index and metadata; after an OSError, only let go of the file."""
        try:
            if error_type is None or not issubclass(error_type, OSError):
                self.flush()  # they take long: until then a kill would cost the last second
                self._writer.close()
        finally:
            with contextlib.suppress(OSError):
                self._writer.abort()

    @property
    def _storage(self) -> McapWriter:
        return cast(McapWriter, self._writer.storage)

    def _write_out(self) -> None:
        # rosbags itself leaves up to 1 MB in memory: minutes of a small fleet.
        self._storage.bio.flush()


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


_TYPE = 'tf2_msgs/msg/TFMessage'
_QOS = {  # as tf2's broadcasters offer it
    TF: QoSProfile(depth=100),
    TF_STATIC: QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL),
}


class TransformRecorder:
    """Writes transforms for programs that show a recording, and know no odometry.

    Attributes:
        wanted: Whether they are to be written: not where somebody publishes them.
    """

    def __init__(self, writer: BagWriter) -> None:
        """Write through a writer, from the first odometry on."""
        self.wanted = True
        self._writer = writer
        self._connections: dict[str, Connection] = {}
        self._now: list[Transform] = []
        self._known: set[str] = set()
        self._base_links: list[Transform] = []

    def take(self, odometry: bytes) -> None:
        """Take an odometry that has just been written.

        Raises:
            OSError: The disk is full, or fails.
        """
        transform = transform_of(odometry) if self.wanted else None
        if transform is None:
            return
        if self._now and transform.stamp != self._now[0].stamp:
            self.write()
        self._now.append(transform)

    def write(self) -> None:
        """Write what was taken, robots of one time in one message.

        Raises:
            OSError: The disk is full, or fails.
        """
        transforms, self._now = self._now, []
        if not transforms or not self.wanted:
            return
        self._write(TF, transforms)
        new = {one.child: one for one in transforms if one.child not in self._known}
        self._known |= new.keys()
        if links := [link for one in new.values() if (link := base_link_of(one))]:
            self._base_links += links  # all in one message: it is latched, and the last one counts
            self._write(TF_STATIC, self._base_links)

    def _write(self, topic: str, transforms: list[Transform]) -> None:
        if topic not in self._connections:
            self._connections[topic] = self._writer.add_topic(
                topic, _TYPE, _definition(), stored_qos([_QOS[topic]])
            )
        self._writer.write(self._connections[topic], self._writer.end_ns, tf_message(transforms))


def _definition() -> Definition:
    known = MessageDefinitions([]).of(_TYPE)
    return Definition(DERIVED + known.text, known.digest)
