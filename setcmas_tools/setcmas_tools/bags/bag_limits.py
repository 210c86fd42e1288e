"""Limits of bags: a small file must not take much memory or time."""

from __future__ import annotations

import struct
from bz2 import BZ2Decompressor
from collections.abc import Iterator
from os import SEEK_END
from pathlib import Path
from typing import Any, NamedTuple

from mcap.stream_reader import lz4, zstandard
from rosbags.rosbag1.reader import decompressors
from rosbags.rosbag2.storage_mcap import DECOMPRESSORS, McapReader
from rosbags.rosbag2.storage_sqlite3 import apsw  # type: ignore[attr-defined]

from setcmas_simu.errors import SetcmasError
from setcmas_simu.limited_file import open_limited

LARGEST_RECORD = 2**26
"""Most bytes of a record, such as a chunk, also when it is decompressed."""

_MOST_BYTES = 2**40
_SMALL_BAG = 2**25
_LARGEST_RATIO = 1000  # of content to file; robots' bags have 10 to 50, constant images more
_LARGEST_OVERLAP = 2**29  # rosbags holds chunks that overlap in time in memory
_BYTES_AT_ONCE = 2**20
_MAGIC = b'\x89MCAP0\r\n'
_HEAD = struct.Struct('<BQ')
_CHUNK_HEAD = struct.Struct('<QQQII')
_FOOTER = struct.Struct('<BQQQI8s')
_CHUNK, _DATA_END = 0x06, 0x0F


def largest_content(path: Path) -> int:
    """Return the most bytes of messages or chunks that a file may hold."""
    return _SMALL_BAG + _LARGEST_RATIO * path.stat().st_size


def zstd_content(data: bytes, most: int = LARGEST_RECORD) -> bytes:
    """Return compressed bytes in full.

    Raises:
        ValueError: There are more than `most`.
        Exception: They are damaged.
    """
    with zstandard.ZstdDecompressor().stream_reader(data) as stream:
        content = stream.read(most + 1)
    if len(content) > most:
        raise ValueError(f'more than {most:,} bytes')
    return content


def decompress_file(packed: Path, target: Path) -> Path:
    """Write the content of a compressed file into another file; return it.

    Raises:
        OSError: A file cannot be read or written.
        SetcmasError: It is damaged or too large.
    """
    most = largest_content(packed)
    with open_limited(packed, _MOST_BYTES) as source, target.open('wb') as file:
        stream = zstandard.ZstdDecompressor().stream_reader(source)
        try:
            while part := stream.read(_BYTES_AT_ONCE):
                file.write(part)
                if file.tell() > most:
                    raise too_large(packed, f'more than {most:,} bytes', most)
        except zstandard.ZstdError as error:
            raise SetcmasError(f"bag '{packed}' is damaged ({error}); it must be whole") from error
    return target


def decompressed(data: bytes, compression: str, size: int) -> bytes:
    """Return a chunk in full.

    Raises:
        ValueError: It has another size than it says, or is larger than LARGEST_RECORD.
        Exception: It is damaged.
    """
    if size > LARGEST_RECORD:
        raise ValueError(f'a chunk has {size:,} bytes; at most {LARGEST_RECORD:,} are read')
    if compression == 'zstd':
        content = zstd_content(data, size)
    elif compression == 'lz4':
        content = bytes(lz4.LZ4FrameDecompressor().decompress(data, max_length=size + 1))
    else:
        content = data
    if len(content) != size:
        raise ValueError(f'a chunk has not the {size:,} bytes that it should have')
    return content


def _within_limit(decompressor: Any, data: bytes) -> bytes:
    content = bytes(decompressor.decompress(data, LARGEST_RECORD + 1))
    if len(content) > LARGEST_RECORD:
        raise ValueError(f'a chunk has more than {LARGEST_RECORD:,} bytes')
    return content


# Those of rosbags have no limit.
decompressors['bz2'] = lambda data: _within_limit(BZ2Decompressor(), data)
decompressors['lz4'] = lambda data: _within_limit(lz4.LZ4FrameDecompressor(), data)
DECOMPRESSORS['zstd'] = lambda data, size: decompressed(data, 'zstd', size)
DECOMPRESSORS['lz4'] = lambda data, size: decompressed(data, 'lz4', size)


class Chunk(NamedTuple):
    """A chunk of a file.

    Attributes:
        offset: Its place in the file.
        start_ns: Time of its first message.
        end_ns: Time of its last message.
        size: Its number of bytes in full.
    """

    offset: int
    start_ns: int
    end_ns: int
    size: int


class McapOutline:
    """The places of a file's records.

    Attributes:
        chunks: Its chunks.
        is_complete: Whether the file was closed well and needs little memory.
    """

    def __init__(self, path: Path) -> None:
        """Go through the heads of the records, up to the end or to the first damage.

        Raises:
            OSError: The file cannot be read.
            SetcmasError: A record or all chunks together are too large.
        """
        self.chunks: list[Chunk] = []
        summary = 0
        self._size = path.stat().st_size
        for offset, kind, length, head in _records(path):
            if length > LARGEST_RECORD and offset + length <= self._size:
                raise too_large(path, f'a record of {length:,} bytes', LARGEST_RECORD)
            if kind == _DATA_END:
                summary = offset + _HEAD.size + length
            if kind == _CHUNK and len(head) == _CHUNK_HEAD.size:
                start, end, size, *_ = _CHUNK_HEAD.unpack(head)
                self.chunks.append(Chunk(offset, start, end, size))
        for chunk in self.chunks:
            if chunk.size > LARGEST_RECORD:
                raise too_large(path, f'a chunk of {chunk.size:,} bytes', LARGEST_RECORD)
        whole = sum(chunk.size for chunk in self.chunks)
        most = largest_content(path)
        if whole > most:
            raise too_large(path, f'chunks of {whole:,} bytes', most)
        self.is_complete = self._is_ordered() and _summary_start(path) in (0, summary)

    def has_chunks_of(self, reader: McapReader) -> bool:
        """Return whether the index that an open reader has read names all chunks as they are."""
        named = [
            Chunk(
                c.chunk_start_offset, c.message_start_time, c.message_end_time, c.uncompressed_size
            )
            for c in reader.chunks
            if c.compressed_size <= LARGEST_RECORD
        ]
        return len(named) == len(reader.chunks) and (not named or sorted(named) == self.chunks)

    def _is_ordered(self) -> bool:
        """Return whether chunks that overlap in time fit into memory together."""
        changes = [(chunk.start_ns, chunk.size) for chunk in self.chunks]
        changes += [(chunk.end_ns + 1, -chunk.size) for chunk in self.chunks]
        held = largest = 0
        for _, change in sorted(changes):
            held += change
            largest = max(largest, held)
        return largest <= _LARGEST_OVERLAP


def _summary_start(path: Path) -> int | None:
    """Return where the summary starts, as the footer says; None in a cut file."""
    with open_limited(path, _MOST_BYTES) as file:
        file.seek(0, SEEK_END)
        file.seek(max(0, file.tell() - _FOOTER.size))
        end = file.read()
    if len(end) != _FOOTER.size or not end.endswith(_MAGIC):
        return None
    start: int = _FOOTER.unpack(end)[2]
    return start


def too_large(path: Path, what: str, most: int) -> SetcmasError:
    """Return the error for a bag beyond a limit."""
    return SetcmasError(f"bag '{path}' holds {what}; at most {most:,} are read")


def _records(path: Path) -> Iterator[tuple[int, int, int, bytes]]:
    """Yield place, kind and length of each record, and the head of what may be a chunk."""
    with open_limited(path, _MOST_BYTES) as file:
        if file.read(len(_MAGIC)) != _MAGIC:
            return
        offset = len(_MAGIC)
        while len(head := file.read(_HEAD.size)) == _HEAD.size:
            kind, length = _HEAD.unpack(head)
            yield offset, kind, length, file.read(_CHUNK_HEAD.size) if kind == _CHUNK else b''
            offset += _HEAD.size + length
            if offset >= 2**63:
                return
            file.seek(offset)


_LEAST_STEPS, _STEPS_PER_BYTE = 10_000_000, 10  # an honest query takes less than one a byte
_STEPS_AT_ONCE = 100_000
_MOST_QUERY_BYTES = 2**30
_STRANGE_TABLES = """
SELECT name FROM pragma_table_list WHERE schema = 'main' AND type <> 'table' UNION ALL
SELECT t.name FROM pragma_table_list AS t, pragma_table_xinfo(t.name) AS c WHERE c.hidden
"""


def _limit_database(database: apsw.Connection) -> None:
    """Limit the steps and the memory of queries; allow tables with stored columns only.

    Views and generated columns run code of the file's author, and pages that refer to each other
    hold any number of rows.

    Raises:
        SetcmasError: There is a view, a virtual table or a generated column.
    """
    path = Path(database.filename)
    size = path.stat().st_size
    database.limit(apsw.SQLITE_LIMIT_LENGTH, min(size, LARGEST_RECORD))
    for name, value in (('trusted_schema', 0), ('cell_size_check', 1), ('temp_store', 2)):
        database.pragma(name, value)
    left = 0

    def start(*_: Any) -> bool:
        nonlocal left
        left = (_LEAST_STEPS + _STEPS_PER_BYTE * size) // _STEPS_AT_ONCE
        return True

    def is_over() -> bool:
        nonlocal left
        left -= 1
        return left < 0

    database.exec_trace = start
    database.set_progress_handler(is_over, _STEPS_AT_ONCE)
    if strange := database.execute(_STRANGE_TABLES).fetchone():
        raise SetcmasError(
            f"bag '{path}' is not read: {strange[0]} is a view or has generated columns; a bag "
            'has tables of stored values only'
        )


apsw.hard_heap_limit(_MOST_QUERY_BYTES)
apsw.connection_hooks.append(_limit_database)  # rosbags opens the connections
