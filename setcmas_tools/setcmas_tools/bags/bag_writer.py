"""Writer of a rosbag2 bag that stays readable when its recorder is killed."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Literal, cast

from rosbags.interfaces import Connection, Qos
from rosbags.rosbag2 import StoragePlugin, Writer, WriterError
from rosbags.rosbag2.storage_mcap import McapWriter

from setcmas_simu.errors import SetcmasError
from setcmas_tools.bags.message_types import Definition

_BAG_VERSION: Literal[9] = 9  # that of ROS 2 Jazzy


class BagWriter:
    """Writes serialised messages to an mcap bag; a context manager that closes it well.

    Messages become readable with each `flush`, whatever happens afterwards. Its methods raise
    OSError if the disk is full or fails.

    Attributes:
        count: Number of messages written.
        start_ns: Time of the first message.
        end_ns: Time of the last message.
    """

    def __init__(self, path: Path) -> None:
        """Create the folder of the bag, or raise SetcmasError."""
        self.path = path
        self.count = 0
        self.start_ns = 0
        self.end_ns = 0
        self._topics: dict[tuple[str, str], Connection] = {}
        self._names: set[str] = set()
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
        """Add a topic by its full name if it is new; pass the result to `write`.

        Players use the quality of service of each publisher.
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
        self._names.add(topic.topic)
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
        topics = len(self._names)
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
