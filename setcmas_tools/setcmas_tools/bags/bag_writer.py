"""Writer of a rosbag2 bag that stays readable when its recorder is killed; copies of cut files."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Literal, cast

from mcap.reader import NonSeekingReader
from mcap.writer import CompressionType
from mcap.writer import Writer as McapFile
from rosbags.interfaces import Connection, Qos
from rosbags.rosbag2 import StoragePlugin, Writer, WriterError
from rosbags.rosbag2.storage_mcap import McapWriter
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


def copy_of_mcap(damaged: Path, target: Path) -> str:
    """Copy what can be read of an mcap file, up to the first damage.

    Returns:
        What happened to the rest, such as 'was cut short'; empty if no message is missing, as in
        a file that only lacks indices.
    """
    size = damaged.stat().st_size
    channels: dict[int, int] = {}
    loss = ''
    with damaged.open('rb') as source, target.open('wb') as file:
        writer = McapFile(file, compression=CompressionType.NONE)
        writer.start(profile='ros2')
        # A length beyond the file is garbage.
        reader = NonSeekingReader(source, validate_crcs=True, record_size_limit=size)
        try:
            for schema, channel, message in reader.iter_messages(log_time_order=False):
                if channel.id not in channels:
                    number = schema and writer.register_schema(
                        schema.name, schema.encoding, schema.data
                    )
                    channels[channel.id] = writer.register_channel(
                        channel.topic, channel.message_encoding, number or 0, channel.metadata
                    )
                writer.add_message(
                    channels[channel.id], message.log_time, message.data, message.publish_time
                )
        except OSError:
            raise
        except Exception:  # of bytes that are no record
            at = source.tell()
            loss = 'was cut short' if at == size else f'is damaged or cut short at byte {at:,}'
        writer.finish()
    return loss
