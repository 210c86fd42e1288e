"""Writer of a rosbag2 bag that stays readable when its recorder is killed, with transforms."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from os import SEEK_END
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, cast
from zlib import crc32

from rosbags.interfaces import (
    Connection,
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import StoragePlugin, Writer, WriterError
from rosbags.rosbag2.storage_mcap import McapWriter
from rosbags.serde import SerdeError

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import TF, TF_STATIC, WORLD_FRAME
from setcmas_tools.bags.bag import DERIVED
from setcmas_tools.bags.message_types import Definition, MessageDefinitions

_BAG_VERSION: Literal[9] = 9  # that of ROS 2 Jazzy
_CHECKSUM_AT = 9 + 24  # of a chunk: after kind, length, two times and a size


class _StorageWriter(McapWriter):
    """Writes the checksum of each chunk, which rosbags leaves out."""

    def close_chunk(self) -> None:
        """Write the chunk; of a process killed meanwhile it is whole, without its checksum."""
        begin, checksum = self.bio.tell(), crc32(self.chunk.bio.getbuffer())
        super().close_chunk()
        self.bio.seek(begin + _CHECKSUM_AT)
        self.bio.write(checksum.to_bytes(4, 'little'))
        self.bio.seek(0, SEEK_END)


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
            self._topics[key] = self._writer.add_connection(
                name,
                msgtype,
                msgdef=definition.text,
                rihs01=definition.digest,
                offered_qos_profiles=offered_qos,
            )
        return self._topics[key]

    def write(self, topic: Connection, time_ns: int, data: bytes) -> None:
        """Write a message with its time of reception, not before the last message."""
        self._writer.write(topic, time_ns, data)
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


_ODOMETRY = 'nav_msgs/msg/Odometry'
_TF_MESSAGE = 'tf2_msgs/msg/TFMessage'
_DEPTHS = {TF: 100, TF_STATIC: 1}  # as tf2's broadcasters offer them
_BASE_LINK_HEIGHT_M = 0.01  # base_joint in turtlebot3_burger.urdf


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
        self._now: list[Any] = []
        self._known: set[str] = set()
        self._base_links: list[Any] = []

    def take(self, odometry: bytes) -> None:
        """Take an odometry that has just been written; ignore it unless it is in the world."""
        if not self.wanted:
            return
        try:
            message: Any = self._definitions.store.deserialize_cdr(odometry, _ODOMETRY)
        except SerdeError:
            return
        if message.header.frame_id != WORLD_FRAME or not message.child_frame_id:
            return
        if self._now and message.header.stamp != self._now[0].header.stamp:
            self.write()
        pose = message.pose.pose
        place = (pose.position.x, pose.position.y, pose.position.z)
        self._now.append(
            self._transform(message.header, message.child_frame_id, place, pose.orientation)
        )

    def write(self) -> None:
        """Write the transforms so far, those of equal time in one message."""
        transforms, self._now = self._now, []
        if not transforms or not self.wanted:
            return
        self._write(TF, transforms)
        new = {
            one.child_frame_id: one for one in transforms if one.child_frame_id not in self._known
        }
        self._known |= new.keys()
        if links := [link for one in new.values() if (link := self._base_link(one))]:
            self._base_links += links  # all in one message: it is latched, and the last one counts
            self._write(TF_STATIC, self._base_links)

    def _base_link(self, transform: Any) -> Any | None:
        """Return the fixed base_link of a base_footprint; None for other frames."""
        robot, slash, frame = transform.child_frame_id.rpartition('/')
        if frame != 'base_footprint':
            return None
        header = self._message(
            'std_msgs/msg/Header', transform.header.stamp, transform.child_frame_id
        )
        upright = self._message('geometry_msgs/msg/Quaternion', 0.0, 0.0, 0.0, 1.0)
        place = (0.0, 0.0, _BASE_LINK_HEIGHT_M)
        return self._transform(header, f'{robot}{slash}base_link', place, upright)

    def _transform(
        self, header: Any, child: str, place: tuple[float, float, float], rotation: Any
    ) -> Any:
        translation = self._message('geometry_msgs/msg/Vector3', *place)
        transform = self._message('geometry_msgs/msg/Transform', translation, rotation)
        return self._message('geometry_msgs/msg/TransformStamped', header, child, transform)

    def _message(self, msgtype: str, *fields: Any) -> Any:
        return self._definitions.store.types[msgtype](*fields)

    def _write(self, topic: str, transforms: list[Any]) -> None:
        if topic not in self._connections:
            known = self._definitions.of(_TF_MESSAGE)
            self._connections[topic] = self._writer.add_topic(
                topic, _TF_MESSAGE, Definition(DERIVED + known.text, known.digest), [_qos(topic)]
            )
        message = self._message(_TF_MESSAGE, transforms)
        data = self._definitions.store.serialize_cdr(message, _TF_MESSAGE)
        self._writer.write(self._connections[topic], self._writer.end_ns, bytes(data))


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
