"""Whole copies of damaged files of a bag: what can be read of them, for rosbags to read."""

from __future__ import annotations

import os
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

from mcap.reader import NonSeekingReader
from mcap.records import Channel, Schema
from mcap.writer import CompressionType, Writer

_ENCODINGS = ('ros2msg', 'ros2idl')
_MAGIC_BYTES = 8


def copy_of(damaged: Path, target: Path) -> str:
    """Copy what can be read of an .mcap or a .db3 file, up to the first damage.

    Returns:
        What happened to the rest, such as 'was cut short'; empty if all was read, as from a file
        that is only unusual.

    Raises:
        OSError: A file cannot be read or written.
        Exception: It is of another format, or nothing in it can be read.
    """
    copy = _copy_of_mcap if damaged.suffix == '.mcap' else _copy_of_database
    return copy(damaged, target)


def _copy_of_mcap(damaged: Path, target: Path) -> str:
    size = damaged.stat().st_size
    channels: dict[int, int] = {}
    loss = ''
    with damaged.open('rb') as source, target.open('wb') as file:
        writer = Writer(file, compression=CompressionType.NONE)
        writer.start(profile='ros2')
        # A length beyond the file is garbage.
        reader = NonSeekingReader(source, validate_crcs=True, record_size_limit=size)
        try:
            for schema, channel, message in reader.iter_messages(log_time_order=False):
                if channel.id not in channels:
                    channels[channel.id] = _added(writer, schema, channel)
                writer.add_message(
                    channels[channel.id], message.log_time, message.data, message.publish_time
                )
        except OSError:
            raise
        except Exception:  # of bytes that are no record
            at = source.tell()
            if at <= _MAGIC_BYTES:
                raise ValueError('it is not mcap') from None
            loss = 'was cut short' if at == size else f'is damaged or cut short at byte {at:,}'
        writer.finish()
    return loss


def _added(writer: Writer, schema: Schema | None, channel: Channel) -> int:
    """Add a channel and its schema; return its number."""
    number = 0
    if schema:
        encoding = schema.encoding if schema.encoding in _ENCODINGS else ''
        text = schema.data.decode(errors='replace').encode()  # Latin-1 in a comment
        number = writer.register_schema(schema.name, encoding, text)
    return int(
        writer.register_channel(channel.topic, channel.message_encoding, number, channel.metadata)
    )


_TABLES = ('schema', 'topics', 'message_definitions', 'messages')


def _copy_of_database(damaged: Path, target: Path) -> str:
    whole = target.with_name('pages.db3')  # SQLite writes into it: it takes the journal back
    for part in [damaged, *damaged.parent.iterdir()]:
        if part == damaged or part.name.startswith(f'{damaged.name}-'):
            shutil.copyfile(part, f'{whole}{part.name.removeprefix(damaged.name)}')
    _remove_cut_page(whole)
    with closing(sqlite3.connect(whole)) as source, closing(sqlite3.connect(target)) as copy:
        source.execute('PRAGMA writable_schema=ON')  # reads a file that is shorter than it says
        source.text_factory = lambda text: text.decode(errors='replace')
        losses = [loss for table in _TABLES if (loss := _copy_rows(source, copy, table))]
        copy.execute('CREATE INDEX timestamp_idx ON messages (timestamp)')
        copy.commit()
    return f'was cut short or is damaged ({losses[0]})' if losses else ''


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
