"""Writer of a rosbag2 bag that stays readable when its recorder is killed, and its definitions."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, cast

from rosbags.interfaces import Connection, Nodetype, Qos
from rosbags.rosbag2 import StoragePlugin, Writer, WriterError
from rosbags.rosbag2.storage_mcap import McapWriter
from rosbags.typesys import TypesysError, get_types_from_msg
from rosbags.typesys.store import Typestore

from setcmas_simu.errors import SetcmasError

_BAG_VERSION: Literal[9] = 9  # that of ROS 2 Jazzy


class BagWriter(Writer):
    """Writes serialised messages to an mcap bag; a context manager that closes it well.

    Messages become readable with each `flush`, whatever happens afterwards. `write` takes a topic,
    a time of reception in ns, not before that of the last message, and the message. Its methods
    raise OSError if the disk is full or fails.
    """

    def __init__(self, path: Path) -> None:
        """Create the folder of the bag, or raise SetcmasError."""
        self._topics: dict[tuple[str, str], Connection] = {}
        try:
            super().__init__(path, version=_BAG_VERSION, storage_plugin=StoragePlugin.MCAP)
            self.open()
            self._write_out()
        except WriterError as error:
            raise SetcmasError(f"'{path}' exists already; it must be a new folder") from error
        except OSError as error:
            raise SetcmasError(f"bag '{path}' cannot be created: {error.strerror}") from error

    def add_topic(
        self, name: str, msgtype: str, types: Typestore, offered_qos: Sequence[Qos]
    ) -> Connection:
        """Add a topic by its full name if it is new; pass the result to `write`.

        Its type is among `types`. Players use the quality of service of each publisher.
        """
        key = (name, msgtype)
        if key not in self._topics:
            self._topics[key] = self.add_connection(
                name, msgtype, typestore=types, offered_qos_profiles=offered_qos
            )
        return self._topics[key]

    @property
    def count(self) -> int:
        """Number of messages written."""
        return sum(self.counts.values())

    def flush(self) -> None:
        """Make all messages so far readable, even if this process is killed."""
        storage = cast(McapWriter, self.storage)
        if storage.chunk.msgs:
            storage.close_chunk()
            self._write_out()

    def __str__(self) -> str:
        """Return a summary, such as '450 messages of 40 topics in 1.0 s'."""
        topics = len({one.topic for one in self.connections if self.counts[one.id]})
        seconds = max(0, self.max_timestamp - self.min_timestamp) / 1e9
        return (
            f'{self.count:,} message{"s" * (self.count != 1)} of {topics} '
            f'topic{"s" * (topics != 1)} in {seconds:.1f} s'
        )

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(
        self,
        error_type: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> Literal[False]:
        """Write index and metadata; after an OSError, only close the file."""
        try:
            if error_type is None or not issubclass(error_type, OSError):
                self.flush()  # closing takes long: a kill would cost the last second
                self.close()
        finally:
            with suppress(OSError):
                self.abort()
        return False

    def _write_out(self) -> None:
        # rosbags itself leaves up to 1 MB in memory: minutes of a small fleet.
        cast(McapWriter, self.storage).bio.flush()


class UnknownDefinitionError(Exception):
    """A message type without a usable definition; the message has the reason."""


def add_definition(msgtype: str, types: Typestore) -> None:
    """Add a message type, such as `nav_msgs/msg/Odometry`, and its parts, unless they are known.

    Those that are not built in have .msg files in the sourced ROS workspaces or in this Python
    environment.

    Raises:
        UnknownDefinitionError: It is neither built in nor installed, or is malformed.
    """
    try:
        _register(msgtype, types)
        types.generate_msgdef(msgtype, ros_version=2)
        types.hash_rihs01(msgtype)
    except (TypesysError, KeyError) as error:
        raise UnknownDefinitionError(f'its definition is malformed: {error}') from error


def _register(msgtype: str, types: Typestore) -> None:
    """Register a type after its parts, unless it is known."""
    if msgtype not in types.fielddefs:
        definition = _installed(msgtype)
        for _, field in definition[1]:
            for part in _part_names(field):
                _register(part, types)
        types.register({msgtype: definition})


def _installed(msgtype: str) -> Any:
    sourced = os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
    for prefix in filter(None, [*sourced, sys.prefix]):
        path = Path(prefix, 'share', f'{msgtype}.msg')
        if path.is_file():
            return get_types_from_msg(path.read_text(encoding='utf-8'), msgtype)[msgtype]
    raise UnknownDefinitionError(f'no file {msgtype}.msg is installed')


def _part_names(field: Any) -> list[str]:
    """Return the message type in a field of a definition; none in one of numbers or texts."""
    kind, detail = field
    if kind == Nodetype.NAME:
        return [detail]
    return _part_names(detail[0]) if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE) else []
