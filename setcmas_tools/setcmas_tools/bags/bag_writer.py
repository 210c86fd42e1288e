"""Writer of a rosbag2 bag that stays readable when its recorder is killed, with transforms."""

from __future__ import annotations

import contextlib
import struct
from collections.abc import Sequence
from functools import lru_cache
from os import SEEK_END
from pathlib import Path
from types import TracebackType
from typing import Literal, NamedTuple, cast
from zlib import crc32

import yaml
from rosbags.interfaces import (
    Connection,
    ConnectionExtRosbag2,
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import StoragePlugin, Writer, WriterError
from rosbags.rosbag2.metadata import dump_qos_v9
from rosbags.rosbag2.storage_mcap import McapWriter

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import TF, TF_STATIC, WORLD_FRAME
from setcmas_tools.bags.bag import DERIVED
from setcmas_tools.bags.message_types import Definition, MessageDefinitions

_BAG_VERSION: Literal[9] = 9  # that of ROS 2 Jazzy
_CHECKSUM_AT = 9 + 24  # of a chunk: after kind, length, two times and a size


_CHUNK_SIZE = 2**20  # bytes, as in rosbags
_MESSAGE = struct.Struct(
    '<BQHIQQ'
)  # kind, length, channel, number, time of arrival, time of sending
_NUMBER = struct.Struct('<I')
_KIND, _HEAD_SIZE = 5, 9  # bytes of kind and length


class _StorageWriter(McapWriter):
    """Writes the checksum of each chunk, which rosbags leaves out, and messages faster.

    Attributes:
        offered: Quality of service of the publishers of the next topic.
    """

    offered: tuple[Qos, ...] = ()

    def add_connection(self, connection: Connection, _: str) -> None:
        """Write a topic."""
        assert isinstance(connection.ext, ConnectionExtRosbag2)
        connection.ext.offered_qos_profiles.extend(self.offered)
        super().add_connection(connection, _text_of(self.offered))

    def write(self, connection: Connection, timestamp: int, data: bytes | memoryview) -> None:
        """Write a message, not older than the last one."""
        number, chunk, place = connection.id, self.chunk, self.chunk.bio.tell()
        length = _MESSAGE.size - _HEAD_SIZE + len(data)
        chunk.bio.write(_MESSAGE.pack(_KIND, length, number, 0, timestamp, timestamp))
        chunk.bio.write(data)
        chunk.msgs[number].append((timestamp, place))
        chunk.message_start_time = min(timestamp, chunk.message_start_time)
        chunk.message_end_time = timestamp
        self.channel_stats[number] += 1
        if chunk.bio.tell() > _CHUNK_SIZE:
            self.close_chunk()

    def close_chunk(self) -> None:
        """Write the chunk; of a process killed meanwhile it is whole, without its checksum."""
        begin, checksum = self.bio.tell(), crc32(self.chunk.bio.getbuffer())
        super().close_chunk()
        self.bio.seek(begin + _CHECKSUM_AT)
        self.bio.write(checksum.to_bytes(4, 'little'))
        self.bio.seek(0, SEEK_END)


@lru_cache  # 2 ms, and hundreds of topics have the same few texts
def _text_of(profiles: tuple[Qos, ...]) -> str:
    text: str = yaml.safe_dump(dump_qos_v9(list(profiles)), default_flow_style=False)
    return text.strip()


class BagWriter:
    """Writes serialised messages to an mcap bag; a context manager that closes it well.

    Messages become readable with each `flush`, whatever happens afterwards. Its methods raise
    OSError where the disk is full or fails.

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
            self._writer.STORAGE_PLUGINS = {StoragePlugin.MCAP: _StorageWriter}
            self._writer.open()
            self._write_out()
        except WriterError as error:
            raise SetcmasError(f"'{path}' exists already; it must be a new folder") from error
        except OSError as error:
            raise SetcmasError(f"bag '{path}' cannot be created: {error.strerror}") from error

    def add_topic(
        self, name: str, msgtype: str, definition: Definition, offered_qos: Sequence[Qos]
    ) -> Connection:
        """Add a topic if it is new; pass the result to `write`.

        Args:
            name: Full name.
            msgtype: Type of its messages.
            definition: That of the type.
            offered_qos: Quality of service of each publisher, for players.
        """
        key = (name, msgtype)
        if key not in self._topics:
            self._storage.offered = tuple(offered_qos)
            self._topics[key] = self._writer.add_connection(
                name, msgtype, msgdef=definition.text, rihs01=definition.digest
            )
        return self._topics[key]

    def write(self, topic: Connection, time_ns: int, data: bytes) -> None:
        """Write a message with its time of reception, not before the last message."""
        self._storage.write(topic, time_ns, data)
        self.types[topic.topic] = topic.msgtype
        self.start_ns = self.start_ns or time_ns
        self.end_ns = time_ns
        self.count += 1

    def flush(self) -> None:
        """Make all messages so far readable, even if this process is killed."""
        if self._storage.chunk.msgs:
            self._storage.close_chunk()
            self._write_out()

    def __str__(self) -> str:
        """Return a summary, such as '450 messages of 40 topics in 1.0 s'."""
        topics = len(self.types)
        return (
            f'{self.count:,} message{"s" * (self.count != 1)} of {topics} '
            f'topic{"s" * (topics != 1)} in {(self.end_ns - self.start_ns) / 1e9:.1f} s'
        )

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(
        self,
        error_type: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Write index and metadata; after an OSError, only close the file."""
        try:
            if error_type is None or not issubclass(error_type, OSError):
                self.flush()  # closing takes long: a kill would cost the last second
                self._close()
        finally:
            with contextlib.suppress(OSError):
                self._writer.abort()

    def _close(self) -> None:
        writer, storage = self._writer, self._storage
        writer.counts = dict(storage.channel_stats)
        if self.count:
            writer.min_timestamp = storage.message_start_time = self.start_ns
            writer.max_timestamp = storage.message_end_time = self.end_ns
        writer.close()

    @property
    def _storage(self) -> _StorageWriter:
        return cast(_StorageWriter, self._writer.storage)

    def _write_out(self) -> None:
        # rosbags itself leaves up to 1 MB in memory: minutes of a small fleet.
        self._storage.bio.flush()


_TF_MESSAGE = 'tf2_msgs/msg/TFMessage'
_DEPTHS = {TF: 100, TF_STATIC: 1}  # as tf2's broadcasters offer them
_LITTLE_ENDIAN = b'\0\1\0\0'
_STAMP_SIZE, _PLACE_SIZE = 8, 7 * 8  # place: position and quaternion, here and in transforms
_VELOCITY_SIZE = 6 * 8
_COVARIANCE_SIZE = 36 * 8
_BASE_LINK_HEIGHT_M = 0.01  # base_joint in turtlebot3_burger.urdf
_ON_BASE = struct.Struct('<7d').pack(0.0, 0.0, _BASE_LINK_HEIGHT_M, 0.0, 0.0, 0.0, 1.0)


class _Transform(NamedTuple):
    """A transform; stamp, and place of the child in the parent, are those of a message in CDR."""

    stamp: bytes
    parent: str
    child: str
    place: bytes


class TransformRecorder:
    """Writes transforms of recorded odometry, for programs that show only transforms.

    Its methods raise OSError where the disk is full or fails.

    Attributes:
        wanted: Whether to write them; not where other nodes publish them.
    """

    def __init__(self, writer: BagWriter) -> None:
        self.wanted = True
        self._writer = writer
        self._connections: dict[str, Connection] = {}
        self._definitions = MessageDefinitions([])
        self._now: list[_Transform] = []
        self._known: set[str] = set()
        self._base_links: list[_Transform] = []

    def take(self, odometry: bytes) -> None:
        """Take an odometry that has just been written; ignore it unless it is in the world."""
        transform = _transform_of(odometry) if self.wanted else None
        if transform is None or transform.parent != WORLD_FRAME or not transform.child:
            return
        if self._now and transform.stamp != self._now[0].stamp:
            self.write()
        self._now.append(transform)

    def write(self) -> None:
        """Write the transforms so far, those of equal time in one message."""
        transforms, self._now = self._now, []
        if not transforms or not self.wanted:
            return
        self._write(TF, transforms)
        new = {one.child: one for one in transforms if one.child not in self._known}
        self._known |= new.keys()
        if links := [link for one in new.values() if (link := _base_link(one))]:
            self._base_links += links  # all in one message: it is latched, and the last one counts
            self._write(TF_STATIC, self._base_links)

    def _write(self, topic: str, transforms: list[_Transform]) -> None:
        if topic not in self._connections:
            known = self._definitions.of(_TF_MESSAGE)
            self._connections[topic] = self._writer.add_topic(
                topic, _TF_MESSAGE, Definition(DERIVED + known.text, known.digest), [_qos(topic)]
            )
        data = _encoded(transforms)
        self._writer.write(self._connections[topic], self._writer.end_ns, data)


def _transform_of(odometry: bytes) -> _Transform | None:
    """Return the pose in an odometry in CDR; None if its bytes are not those of an odometry."""
    texts: list[str] = []
    end = len(_LITTLE_ENDIAN) + _STAMP_SIZE
    try:
        for _ in ('parent', 'child'):
            begin = end + -end % 4 + _NUMBER.size
            end = begin + _NUMBER.unpack_from(odometry, begin - _NUMBER.size)[0]
            texts.append(odometry[begin : end - 1].decode())
    except (struct.error, UnicodeDecodeError):
        return None
    begin = end + (len(_LITTLE_ENDIAN) - end) % 8
    end = begin + _PLACE_SIZE
    size = end + 2 * _COVARIANCE_SIZE + _VELOCITY_SIZE
    if len(odometry) < size or odometry[:2] != _LITTLE_ENDIAN[:2]:
        return None
    stamp = odometry[len(_LITTLE_ENDIAN) : len(_LITTLE_ENDIAN) + _STAMP_SIZE]
    parent, child = texts
    return _Transform(stamp, parent, child, odometry[begin:end])


def _base_link(transform: _Transform) -> _Transform | None:
    """Return the fixed base_link of a base_footprint; None for other frames."""
    robot, slash, frame = transform.child.rpartition('/')
    if frame != 'base_footprint':
        return None
    return _Transform(transform.stamp, transform.child, f'{robot}{slash}base_link', _ON_BASE)


def _encoded(transforms: Sequence[_Transform]) -> bytes:
    """Return a TFMessage in CDR."""
    data = bytearray(_LITTLE_ENDIAN + _NUMBER.pack(len(transforms)))
    for stamp, parent, child, place in transforms:
        data += stamp
        for text in (parent, child):
            encoded = text.encode() + b'\0'
            data += bytes(-len(data) % 4) + _NUMBER.pack(len(encoded)) + encoded
        data += bytes((len(_LITTLE_ENDIAN) - len(data)) % 8) + place
    return bytes(data)


def _qos(topic: str) -> Qos:
    durability = QosDurability.TRANSIENT_LOCAL if topic == TF_STATIC else QosDurability.VOLATILE
    never = QosTime(0, 0)
    return Qos(
        QosHistory.KEEP_LAST,
        _DEPTHS[topic],
        QosReliability.RELIABLE,
        durability,
        never,
        never,
        QosLiveliness.SYSTEM_DEFAULT,
        never,
        False,
    )
