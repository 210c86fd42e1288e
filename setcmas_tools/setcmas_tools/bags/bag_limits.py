"""Limits of bags: a small file must not take much memory or time."""

from __future__ import annotations

from bz2 import BZ2Decompressor
from pathlib import Path
from typing import Any
from zlib import crc32

from mcap.records import Chunk
from mcap.stream_reader import lz4, zstandard
from rosbags.rosbag1.reader import decompressors
from rosbags.rosbag2.storage_sqlite3 import apsw  # type: ignore[attr-defined]

from setcmas_simu.errors import SetcmasError
from setcmas_simu.limited_file import open_limited

LARGEST_RECORD = 2**26
"""Most bytes of a record, such as a chunk, also when it is decompressed."""

_MOST_BYTES = 2**40
_SMALL_BAG = 2**25
_LARGEST_RATIO = 1000  # of content to file; robots' bags have 10 to 50, constant images more
_BYTES_AT_ONCE = 2**20


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


def decompressed(chunk: Chunk) -> bytes:
    """Return the content of a chunk of an mcap file, of at most LARGEST_RECORD.

    Raises:
        ValueError: Its size or checksum is wrong.
        Exception: It is damaged.
    """
    size, content = chunk.uncompressed_size, chunk.data
    if chunk.compression == 'zstd':
        content = zstd_content(content, size)
    elif chunk.compression == 'lz4':
        content = bytes(lz4.LZ4FrameDecompressor().decompress(content, max_length=size + 1))
    if len(content) != size or chunk.uncompressed_crc not in (0, crc32(content)):
        raise ValueError(f'a chunk does not have the {size:,} bytes that it claims')
    return content


def _within_limit(decompressor: Any, data: bytes) -> bytes:
    content = bytes(decompressor.decompress(data, LARGEST_RECORD + 1))
    if len(content) > LARGEST_RECORD:
        raise ValueError(f'a chunk has more than {LARGEST_RECORD:,} bytes')
    return content


# Those of rosbags have no limit.
decompressors['bz2'] = lambda data: _within_limit(BZ2Decompressor(), data)
decompressors['lz4'] = lambda data: _within_limit(lz4.LZ4FrameDecompressor(), data)


def too_large(path: Path, what: str, most: int) -> SetcmasError:
    """Return the error for a bag beyond a limit."""
    return SetcmasError(f"bag '{path}' holds {what}; at most {most:,} are read")


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
