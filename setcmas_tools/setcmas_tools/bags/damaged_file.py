"""Whole copies of damaged files of a bag: what can be read of them, for rosbags to read."""

from __future__ import annotations

import os
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

from mcap.exceptions import InvalidMagic
from mcap.records import Channel, Chunk, DataEnd, Message, Schema
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import CompressionType, Writer

_ENCODINGS = ('ros2msg', 'ros2idl')


class _McapCopy:
    """Messages of a damaged file, written to a new one.

    Attributes:
        count: Number of messages.
    """

    def __init__(self, writer: Writer) -> None:
        self.count = 0
        self._writer = writer
        self._schemas: dict[int, int] = {0: 0}
        self._channels: dict[int, int] = {}
        self._start_ns = self._end_ns = 0

    def add(self, record: Any) -> None:
        """Add a record; others than messages and their definitions are not needed."""
        if isinstance(record, Schema) and record.id not in self._schemas:
            encoding = record.encoding if record.encoding in _ENCODINGS else ''
            text = record.data.decode(errors='replace').encode()  # Latin-1 in a comment
            self._schemas[record.id] = self._writer.register_schema(record.name, encoding, text)
        elif isinstance(record, Channel) and record.id not in self._channels:
            self._channels[record.id] = self._writer.register_channel(
                record.topic,
                record.message_encoding,
                self._schemas[record.schema_id],
                record.metadata,
            )
        elif isinstance(record, Message):
            self._writer.add_message(
                self._channels[record.channel_id],
                record.log_time,
                record.data,
                record.publish_time,
                record.sequence,
            )
            self._start_ns = (
                min(self._start_ns, record.log_time) if self.count else record.log_time
            )
            self._end_ns = max(self._end_ns, record.log_time)
            self.count += 1

    def __str__(self) -> str:
        """Return text such as '3,412 messages up to 12.3 s'."""
        seconds = (self._end_ns - self._start_ns) / 1e9
        return f'{self.count:,} messages up to {seconds:.1f} s' if self.count else 'no messages'


def copy_of_mcap(damaged: Path, target: Path) -> str:
    """Copy the messages of the whole chunks of an mcap file.

    Returns:
        What is lost; empty if nothing is, as in a file that is only unusual.

    Raises:
        InvalidMagic: It is not mcap.
        OSError: A file cannot be read or written.
    """
    size = damaged.stat().st_size
    good_end = nb_lost = 0
    has_ended = has_failed = False
    with damaged.open('rb') as source, target.open('wb') as file:
        writer = Writer(file, compression=CompressionType.NONE)
        writer.start(profile='ros2')
        copy = _McapCopy(writer)
        # A length beyond the file is garbage.
        records = StreamReader(source, emit_chunks=True, record_size_limit=size).records
        try:
            for record in records:
                nb_lost += not _is_added(record, copy)
                good_end = source.tell()
                has_ended |= isinstance(record, DataEnd)
        except InvalidMagic:
            if not good_end:
                raise
            has_failed = True
        except OSError:
            raise
        except Exception:  # of bytes that are no record
            has_failed = True
        writer.finish()
    if nb_lost:
        return f'is damaged: {nb_lost} of its chunks cannot be read; {copy} were read'
    if has_failed and has_ended:
        return (
            'was not closed properly, its index is missing: '
            f'all its {copy.count:,} messages were read'
        )
    rest = size - good_end
    lost = f'the last {rest:,} bytes are incomplete' if rest else 'which is all that it holds'
    return f'was cut short: {copy} were read, {lost}' if has_failed else ''


def _is_added(record: Any, copy: _McapCopy) -> bool:
    """Add a record, or those of a chunk unless it is damaged; return whether it could be read."""
    try:
        for part in breakup_chunk(record, True) if isinstance(record, Chunk) else [record]:
            copy.add(part)
    except OSError:
        raise
    except Exception:  # of any of the decompressors; or of a topic that a lost chunk defined
        return False
    return True


_TABLES = ('schema', 'topics', 'message_definitions', 'messages')
_JOURNALS = ('-wal', '-journal')


def has_journal(database: Path) -> bool:
    """Return whether a .db3 file was not closed: its journal has some of its content."""
    return any(Path(f'{database}{ending}').exists() for ending in _JOURNALS)


def copy_of_database(damaged: Path, target: Path) -> str:
    """Copy the rows of a .db3 file up to the first that cannot be read, as `copy_of_mcap` does.

    Raises:
        sqlite3.Error: No topic can be read.
    """
    whole = target.with_name('pages.db3')  # SQLite writes into it: it takes the journal back
    for ending in ('', *_JOURNALS):
        if (part := Path(f'{damaged}{ending}')).exists():
            shutil.copyfile(part, f'{whole}{ending}')
    _remove_cut_page(whole)
    with (
        closing(sqlite3.connect(whole)) as source,
        closing(sqlite3.connect(target)) as copy,
    ):
        source.execute('PRAGMA writable_schema=ON')  # reads a file that is shorter than it says
        source.text_factory = lambda text: text.decode(errors='replace')
        losses = [loss for table in _TABLES if (loss := _copy_rows(source, copy, table))]
        copy.execute('CREATE INDEX timestamp_idx ON messages (timestamp)')
        copy.commit()
        query = 'SELECT COUNT(*), MAX(timestamp) - MIN(timestamp) FROM messages'
        ((count, duration),) = copy.execute(query)
    read = f'{count:,} messages up to {(duration or 0) / 1e9:.1f} s were read'
    return f'was cut short or is damaged ({losses[0]}): {read}, the rest is lost' if losses else ''


def _copy_rows(source: sqlite3.Connection, copy: sqlite3.Connection, table: str) -> str:
    """Copy the rows of a table; return why the rest of them cannot be read, empty if all were."""
    try:
        rows = source.execute(f'SELECT * FROM {table}')
    except sqlite3.OperationalError:  # bags from before Iron have two tables only
        return ''
    names = [name for name, *_ in rows.description]
    columns = ', '.join(f'"{name}"' for name in names)
    copy.execute(f'CREATE TABLE {table} ({columns})')
    insert = f'INSERT INTO {table} VALUES ({", ".join("?" * len(names))})'
    try:
        copy.executemany(insert, rows)
    except sqlite3.OperationalError:  # the disk is full
        raise
    except sqlite3.DatabaseError as error:
        return str(error)
    return ''


def _remove_cut_page(database: Path) -> None:
    """Shorten a file to whole pages: SQLite would take what a cut one lacks for zeros."""
    with database.open('rb') as file:
        head = file.read(18)
    size = int.from_bytes(head[16:], 'big')
    page = 65536 if size == 1 else size  # as its format says
    if head.startswith(b'SQLite format 3') and page:
        os.truncate(database, database.stat().st_size // page * page)
