"""Sources of messages: files of a bag, whole, cut short or damaged."""

from __future__ import annotations

import struct
from bisect import bisect_left
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from io import BytesIO
from itertools import islice
from math import inf
from operator import itemgetter
from pathlib import Path
from typing import Any, Protocol

from mcap.data_stream import ReadDataStream
from mcap.exceptions import InvalidMagic, McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, DataEnd, Message, Schema, Statistics
from mcap.stream_reader import StreamReader
from rosbags.interfaces import (
    Connection,
    ConnectionExtRosbag2,
    MessageDefinition,
    MessageDefinitionFormat,
    Qos,
)
from rosbags.rosbag1 import Reader as Ros1Reader
from rosbags.rosbag2 import Reader as Ros2Reader
from rosbags.rosbag2.metadata import parse_qos

from setcmas_simu.errors import SetcmasError
from setcmas_tools.bags.bag_limits import LARGEST_RECORD, decompressed, largest_content, too_large

Entry = tuple[Connection, int, bytes]
"""Connection, receive time in ns, and the serialised message."""

_LONGEST_REASON = 120


def one_line(error: Exception) -> str:
    """Return the message of a library's error in one line that fits a terminal."""
    text = ' '.join(str(error).split()) or 'inconsistent content'
    return text if len(text) <= _LONGEST_REASON else f'{text[:_LONGEST_REASON]} ...'


@dataclass
class Extent:
    """Number of messages, and times of the first and the last in ns."""

    count: int = 0
    start_ns: int = 0
    end_ns: int = 0

    def add(self, time_ns: int) -> None:
        """Count a message."""
        self.start_ns = min(self.start_ns, time_ns) if self.count else time_ns
        self.end_ns = max(self.end_ns, time_ns) if self.count else time_ns
        self.count += 1

    def __str__(self) -> str:
        """Return text such as '3,412 messages up to 12.3 s'."""
        if not self.count:
            return 'no messages'
        return f'{self.count:,} messages up to {(self.end_ns - self.start_ns) / 1e9:.1f} s'


class BagSource(Protocol):
    """One file of a bag.

    Attributes:
        connections: Topic, type, definition and number of messages of each connection.
        extent: The messages that can be read.
        notices: A line for each loss; complete once `messages` has ended.
        most_bytes: Limit of the bytes of all messages together.
    """

    connections: list[Connection]
    extent: Extent
    notices: list[str]
    most_bytes: int

    def messages(self) -> Iterator[Entry]:
        """Yield all messages."""

    def close(self) -> None:
        """Release the file."""


class IndexedSource:
    """A file, or a folder, that rosbags opens."""

    def __init__(self, path: Path, reader: Ros1Reader | Ros2Reader) -> None:
        """Open a file.

        Args:
            path: The file, for messages.
            reader: A reader of it that is not open yet.
        """
        self._path = path
        self._reader = reader
        self.most_bytes = largest_content(path)
        reader.open()
        self.connections: list[Connection] = list(reader.connections)
        # Readers put the end a nanosecond after the last message.
        self.extent = Extent(reader.message_count, reader.start_time, reader.end_time - 1)
        self.notices: list[str] = []

    def messages(self) -> Iterator[Entry]:
        """Yield all messages up to the first damage, which gets a notice."""
        read = Extent()
        reason = 'some are missing'
        try:
            for entry in self._reader.messages():
                read.add(entry[1])
                yield entry
        except Exception as error:  # a damaged file makes any of several libraries fail
            reason = one_line(error)
        notice = f"'{self._path}' is damaged ({reason}): {read} of {self.extent.count:,} were read"
        if read.count < self.extent.count and notice not in self.notices:
            self.notices.append(notice)

    def close(self) -> None:
        """Release the file."""
        self._reader.close()


_GARBAGE = (McapError, MemoryError, OverflowError, ValueError, struct.error)
"""Errors of reading bytes that are no records."""

_FORMATS = {'ros2msg': MessageDefinitionFormat.MSG, 'ros2idl': MessageDefinitionFormat.IDL}
_HEAD = struct.Struct('<BQ')  # kind and length of a record
_MESSAGE = struct.Struct('<HIQQ')  # channel, number, time of arrival, time of sending
_LARGEST_OVERLAP = 2**29
_INDEXES = (Opcode.MESSAGE_INDEX, Opcode.CHUNK_INDEX)
_TIME = itemgetter(1)

Raw = tuple[int, int, bytes]
"""Number of the channel, receive time in ns, and the serialised message."""


class _Records(StreamReader):
    """Records of a file; those of its index, one for each topic and chunk, are not parsed."""

    def _read_record(self, opcode: int, length: int) -> Any:
        if opcode not in _INDEXES:
            return super()._read_record(opcode, length)
        return self._stream.read(length)


class McapSource:
    """An mcap file: the messages of its whole chunks, also if it was cut short or damaged.

    Its attributes are those of `BagSource`.
    """

    def __init__(self, path: Path) -> None:
        """Scan a file.

        Raises:
            SetcmasError: The content is not mcap, or its chunks are too large.
        """
        self._path = path
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        self._good_end = 0
        self._data_ended = False
        self._damaged: list[Chunk] = []
        self._claimed = 0
        self._was_cut = False
        self.most_bytes = largest_content(path)
        counts = self._counts()
        if self._damaged:  # the end of the file repeats the topics that a lost chunk defined
            counts = self._counts()
        self.connections = [self._connection(c, counts[c.id]) for c in self._channels.values()]
        self.notices = list(self._losses())

    def messages(self) -> Iterator[Entry]:
        """Yield all messages of whole chunks, in the order of time."""
        connections = {connection.id: connection for connection in self.connections}
        # A file that is still being recorded has grown since it was opened.
        for channel, time_ns, data in islice(self._scan(), self.extent.count):
            yield connections[channel], time_ns, data

    def close(self) -> None:
        """Do nothing: the file is open only while it is scanned."""

    def _counts(self) -> Counter[int]:
        self.extent = Extent()
        counts: Counter[int] = Counter()
        for channel, time_ns, _ in self._scan():
            counts[channel] += 1
            self.extent.add(time_ns)
        return counts

    def _scan(self) -> Iterator[Raw]:
        size = self._path.stat().st_size
        self._damaged = []
        self._failed = False
        total = overlap = 0
        waiting: list[Raw] = []  # the next chunk may have earlier messages
        with self._path.open('rb') as stream:
            # A cut record may exceed its file; a larger claim is garbage.
            reader = _Records(stream, emit_chunks=True, record_size_limit=LARGEST_RECORD)
            try:
                for record in reader.records:
                    if isinstance(record, Chunk):
                        total += record.uncompressed_size
                        self._check_sizes(record.uncompressed_size, total)
                        start = record.message_start_time if overlap < _LARGEST_OVERLAP else inf
                        due = bisect_left(waiting, start, key=_TIME)
                        yield from waiting[:due]
                        del waiting[:due]
                        overlap = record.uncompressed_size + overlap * bool(waiting)
                        waiting += self._messages_in(record)
                        waiting.sort(key=_TIME)
                    elif isinstance(record, Message) and record.channel_id in self._channels:
                        yield record.channel_id, record.log_time, record.data
                    else:
                        self._note(record)
                    self._good_end = stream.tell()
            except InvalidMagic as error:
                if not self._good_end:
                    raise SetcmasError(f"'{self._path}' is not a bag: it is not mcap") from error
                self._failed = True
            except _GARBAGE:
                self._failed = True
                self._was_cut = stream.tell() == size
        yield from waiting

    def _check_sizes(self, chunk: int, total: int) -> None:
        if chunk > LARGEST_RECORD:
            raise too_large(self._path, f'a chunk of {chunk:,} bytes', LARGEST_RECORD)
        if total > self.most_bytes:
            raise too_large(self._path, f'chunks of {total:,} bytes', self.most_bytes)

    def _messages_in(self, chunk: Chunk) -> list[Raw]:
        found = []
        end = 0
        try:
            data = decompressed(chunk)
            while end < len(data):
                kind, length = _HEAD.unpack_from(data, end)
                begin, end = end + _HEAD.size, end + _HEAD.size + length
                if not kind or end > len(data):
                    raise ValueError('no record')
                if kind == Opcode.MESSAGE:
                    channel, _, time_ns, _ = _MESSAGE.unpack_from(data, begin)
                    found.append((channel, time_ns, data[begin + _MESSAGE.size : end]))
                elif kind == Opcode.SCHEMA:
                    self._note(Schema.read(ReadDataStream(BytesIO(data[begin:end]))))
                elif kind == Opcode.CHANNEL:
                    self._note(Channel.read(ReadDataStream(BytesIO(data[begin:end]))))
        except Exception:  # of any of the decompressors
            self._damaged.append(chunk)
            return []
        return [one for one in found if one[0] in self._channels]

    def _note(self, record: Any) -> None:
        if isinstance(record, Schema):
            self._schemas[record.id] = record
        elif isinstance(record, Channel):
            self._channels.setdefault(record.id, record)
        elif isinstance(record, DataEnd):
            self._data_ended = True
        elif isinstance(record, Statistics):
            self._claimed = record.message_count

    def _connection(self, channel: Channel, count: int) -> Connection:
        schema = self._schemas.get(channel.schema_id)
        form = _FORMATS.get(schema.encoding if schema else '', MessageDefinitionFormat.NONE)
        text = schema.data.decode(errors='replace') if schema else ''
        return Connection(
            channel.id,
            channel.topic,
            schema.name if schema else '',
            MessageDefinition(form, text),
            '',
            count,
            ConnectionExtRosbag2(channel.message_encoding, _offered_qos(channel)),
            self,
        )

    def _lost(self) -> str:
        number = len(self._damaged)
        if number > 1:
            return f'{number} chunks with a wrong checksum or size are'
        (chunk,) = self._damaged
        begin, end = chunk.message_start_time, chunk.message_end_time
        start = min(begin, self.extent.start_ns) if self.extent.count else begin
        times = f'{(begin - start) / 1e9:.1f} to {(end - start) / 1e9:.1f} s'
        return f'a chunk with a wrong checksum or size, {times}, is'

    def _losses(self) -> Iterator[str]:
        if self._damaged:
            yield f"'{self._path}' is damaged: {self._lost()} left out; {self.extent} were read"
        elif self.extent.count < self._claimed:
            yield f"'{self._path}' is damaged: {self.extent} of {self._claimed:,} were read"
        missing = self._path.stat().st_size - self._good_end
        if self._data_ended and self._failed:
            yield (
                f"'{self._path}' was not closed properly, its index is missing: "
                f'all its {self.extent.count:,} messages were read'
            )
        elif self._failed:
            what, rest = ('cut short', 'incomplete') if self._was_cut else ('damaged', 'lost')
            rest = f'the last {missing:,} bytes are {rest}' if missing else 'all that it holds'
            yield f"'{self._path}' was {what}: {self.extent} were read, {rest}"


def _offered_qos(channel: Channel) -> list[Qos]:
    return list(_parsed_qos(channel.metadata.get('offered_qos_profiles', '')))


@lru_cache  # parsing takes 6 ms, and hundreds of topics have the same few texts
def _parsed_qos(text: str) -> tuple[Qos, ...]:
    try:
        return tuple(parse_qos(text))
    except Exception:  # of a damaged text, by any of rosbags' and its parser's
        return ()
