"""Reading of ROS 1 bags without an index, as a killed `rosbag record` leaves them.

The format is that of wiki.ros.org/Bags/Format/2.0: records of a header (fields `name=value`) and
data, of which chunks hold messages and connections.
"""

from __future__ import annotations

import io
import struct
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from rosbags.interfaces import Connection, ConnectionExtRosbag1
from rosbags.rosbag1.reader import decompressors
from rosbags.typesys.msg import normalize_msgtype

from setcmas_simu.errors import SetcmasError
from setcmas_tools.bags.source import Entry, Extent, message_definition

_MAGIC = b'#ROSBAG V2.0\n'
_MESSAGE, _CHUNK, _CONNECTION = b'\x02', b'\x05', b'\x07'
_GARBAGE = (EOFError, KeyError, MemoryError, OSError, RuntimeError, ValueError, struct.error)
"""What reading and decompressing provoke where records should be."""

Header = dict[bytes, bytes]


class Ros1Salvage:
    """The complete chunks of a ROS 1 bag, in the order of the file.

    Attributes:
        connections: Topic, type, definition and number of messages of each connection.
        extent: What could be read.
        notices: A line that tells what was lost.
    """

    def __init__(self, path: Path) -> None:
        """Scan a file.

        Raises:
            SetcmasError: The content is not a ROS 1 bag of version 2.0.
        """
        self._path = path
        self._good_end = 0
        self._found: dict[int, Connection] = {}
        self.extent = Extent()
        counts: Counter[int] = Counter()
        for number, time_ns, _ in self._scan():
            counts[number] += 1
            self.extent.add(time_ns)
        self.connections = [c._replace(msgcount=counts[c.id]) for c in self._found.values()]
        missing = path.stat().st_size - self._good_end
        rest = f'the last {missing:,} bytes are incomplete' if missing else 'all that it holds'
        self.notices = [f"'{path}' was not closed properly: {self.extent} were read, {rest}"]

    def messages(self) -> Iterator[Entry]:
        """Yield all messages of complete chunks."""
        connections = {connection.id: connection for connection in self.connections}
        for number, time_ns, data in self._scan():
            yield connections[number], time_ns, data

    def close(self) -> None:
        """Do nothing: the file is open only while it is scanned."""

    def _scan(self) -> Iterator[tuple[int, int, bytes]]:
        with self._path.open('rb') as stream:
            if stream.readline(len(_MAGIC)) != _MAGIC:
                raise SetcmasError(f"'{self._path}' is not a bag: it is not a ROS 1 bag")
            try:
                for header, data in _records(stream):
                    yield from self._messages_in(header, data)
                    self._good_end = stream.tell()
            except _GARBAGE:
                return

    def _messages_in(self, header: Header, data: bytes) -> Iterator[tuple[int, int, bytes]]:
        if header[b'op'] == _CHUNK:
            chunk = decompressors[header[b'compression'].decode()](data)
            for inner_header, inner_data in _records(io.BytesIO(chunk)):
                yield from self._messages_in(inner_header, inner_data)
        elif header[b'op'] == _CONNECTION:
            (number,) = struct.unpack('<I', header[b'conn'])
            self._found.setdefault(number, self._connection(number, header, data))
        elif header[b'op'] == _MESSAGE:
            number, seconds, nanoseconds = struct.unpack('<III', header[b'conn'] + header[b'time'])
            if number in self._found:
                yield number, seconds * 10**9 + nanoseconds, data

    def _connection(self, number: int, header: Header, data: bytes) -> Connection:
        fields = _fields(data)
        return Connection(
            number,
            header[b'topic'].decode(),
            normalize_msgtype(fields[b'type'].decode()),
            message_definition('ros2msg', fields[b'message_definition'].decode()),
            digest='',
            msgcount=0,
            ext=ConnectionExtRosbag1(None, None),
            owner=self,
        )


def _records(stream: BinaryIO) -> Iterator[tuple[Header, bytes]]:
    while prefix := stream.read(4):
        header = _fields(_read(stream, prefix))
        yield header, _read(stream, stream.read(4))


def _read(stream: BinaryIO, prefix: bytes) -> bytes:
    (length,) = struct.unpack('<I', prefix)
    data = stream.read(length)
    if len(data) < length:
        raise EOFError
    return data


def _fields(data: bytes) -> Header:
    fields = {}
    stream = io.BytesIO(data)
    while prefix := stream.read(4):
        name, _, value = _read(stream, prefix).partition(b'=')
        fields[name] = value
    return fields
