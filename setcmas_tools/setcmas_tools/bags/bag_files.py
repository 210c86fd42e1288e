"""Readers of a bag's files, and of a copy of what is left of an mcap file that was cut short."""

from __future__ import annotations

import tempfile
from contextlib import ExitStack, suppress
from pathlib import Path, PurePath
from typing import TypeAlias

import yaml
from mcap.reader import NonSeekingReader
from mcap.writer import CompressionType, Writer
from rosbags.rosbag1 import Reader as Ros1Reader
from rosbags.rosbag2 import Reader as Ros2Reader
from rosbags.rosbag2.storage_mcap import McapReader

from setcmas_simu.errors import SetcmasError

BAGS = 'a rosbag2 folder, an .mcap or a .db3 file, or a ROS 1 .bag file'
_ROS2 = ('.mcap', '.db3', '.zstd')
_ROS1 = '.bag'
_REPAIRS = {
    '.db3': 'sqlite3 FILE .recover recovers a damaged one',
    '.bag': 'rosbag reindex recovers a damaged one',
    '.zstd': 'zstd -d FILE unpacks it',
}
_LONGEST_REASON = 120

BagReader: TypeAlias = Ros1Reader | Ros2Reader


def one_line(error: Exception) -> str:
    """Return the message of a library's error in one line that fits a terminal."""
    text = ' '.join(str(error).split()) or 'inconsistent content'
    return text if len(text) <= _LONGEST_REASON else f'{text[:_LONGEST_REASON]} ...'


def open_readers(path: Path, stack: ExitStack) -> tuple[list[BagReader], list[str]]:
    """Open a bag: as a whole if it was closed well, else each of its files that can be read.

    Args:
        path: A rosbag2 folder with or without its metadata.yaml, one of its files, a ROS 1 .bag
            file, or the folder of a run that holds a folder `bag`.
        stack: Closes the readers at the end, and removes copies of damaged files.

    Returns:
        At least one reader, and a line for each file that cannot be read whole, and for files
        that metadata.yaml lists but that are not there.

    Raises:
        SetcmasError: There is no such path, it is not a bag, or no file of it can be read.
        OSError: A file cannot be read for another reason than its content.
    """
    if not path.exists():
        raise SetcmasError(f"there is no bag '{path}'; it must be {BAGS}")
    files = [path] if path.is_file() else sorted(f for f in path.iterdir() if f.suffix in _ROS2)
    listed, found = _listed_names(path), {file.name for file in files}
    is_complete = listed == found and not any(map(_unread_journal, files))
    if is_complete and (whole := _whole_bag(path, stack)):
        return [whole], []
    if not files and (path / 'bag').is_dir():
        return open_readers(path / 'bag', stack)
    if not files or files[0].suffix not in (*_ROS2, _ROS1):
        raise SetcmasError(f"'{path}' is not a bag; it must be {BAGS}")
    readers, losses = [], []
    for file in files:
        try:
            reader, loss = _file_reader(file, stack)
        except SetcmasError as error:  # the other files may be readable
            loss = str(error)
        else:
            readers.append(reader)
        losses += [loss] * bool(loss)
    if not readers:
        raise SetcmasError(losses[0])
    if missing := sorted(listed - found):
        losses.append(f"'{path}' lacks {', '.join(missing)}, which its metadata.yaml lists")
    return readers, losses


def _listed_names(folder: Path) -> set[str]:
    """Return the names of the files that metadata.yaml lists; none if it cannot be read."""
    try:
        content = yaml.safe_load((folder / 'metadata.yaml').read_text())
        paths = content['rosbag2_bagfile_information']['relative_file_paths']
        return {PurePath(path).name for path in paths}
    except (OSError, ValueError, yaml.YAMLError, KeyError, TypeError):
        return set()


def _unread_journal(file: Path) -> str:
    """Return a line about messages in a journal of SQLite, which rosbags does not read."""
    journal = file.with_name(f'{file.name}-wal')
    if not journal.is_file() or not journal.stat().st_size:
        return ''
    return (
        f"messages in '{journal}' were not read; first run sqlite3 '{file}' "
        '"PRAGMA wal_checkpoint(TRUNCATE)"'
    )


def _whole_bag(folder: Path, stack: ExitStack) -> BagReader | None:
    """Return the reader of a bag that was closed well; None if its files must be read singly."""
    with suppress(Exception):  # a damaged file makes any of several libraries fail
        reader = _opened(folder, stack)
        if reader.message_count:
            return reader
    return None


def _opened(path: Path, stack: ExitStack) -> BagReader:
    """Open a bag or a file, or raise any exception."""
    if path.suffix == _ROS1:
        return stack.enter_context(Ros1Reader(path))
    reader = stack.enter_context(Ros2Reader(path))
    for storage in getattr(reader.storage, 'storages', [reader.storage]):  # of a folder: several
        if isinstance(storage, McapReader):
            indexed = sum(sum(chunk.channel_count.values()) for chunk in storage.chunks)
            if indexed != storage.metadata.message_count:  # rosbags reads by the index alone
                raise ValueError('messages are missing in its index')
    return reader


def _file_reader(file: Path, stack: ExitStack) -> tuple[BagReader, str]:
    """Return the reader of a file, and a line if it cannot be read whole."""
    try:
        return _opened(file, stack), _unread_journal(file)
    except Exception as error:
        if file.suffix != '.mcap':
            raise SetcmasError(
                _unread_journal(file)
                or f"bag '{file}' cannot be read ({one_line(error)}); it must be whole "
                f'({_REPAIRS[file.suffix]})'
            ) from error
    folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix='setcmas_bag_')))
    copy = folder / file.name
    loss = _copy_of_mcap(file, copy)
    reader = _opened(copy, stack)
    if not loss:
        return reader, ''
    count, duration = reader.message_count, reader.end_time - 1 - reader.start_time
    if not count:
        raise SetcmasError(f"bag '{file}' {loss}: no messages were read")
    return reader, f"'{file}' {loss}: {count:,} messages up to {duration / 1e9:.1f} s were read"


def _copy_of_mcap(damaged: Path, target: Path) -> str:
    """Copy what can be read of an mcap file, up to the first damage.

    Returns:
        What happened to the rest, such as 'was cut short'; empty if no message is missing, as in
        a file that only lacks indices.
    """
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
