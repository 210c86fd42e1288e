"""Files of a bag: found in its folder, decompressed, and made whole where they were cut short."""

from __future__ import annotations

import re
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import zstandard
from rosbags.rosbag1 import Reader as Ros1Reader
from rosbags.rosbag2 import Reader as Ros2Reader
from rosbags.rosbag2.storage_mcap import McapReader

from setcmas_simu.errors import SetcmasError
from setcmas_simu.limited_file import read_limited

BAGS = 'a rosbag2 folder, an .mcap or a .db3 file, or a ROS 1 .bag file'
_PACKED = '.zstd'
_JOURNALS = ('-wal', '-journal')
_ZSTD_MAGIC = b'\x28\xb5\x2f\xfd'  # no message in CDR begins with it
_LONGEST_REASON = 120
_MOST_METADATA_BYTES = 1_000_000
_TOTAL = re.compile(rb'^ {2}message_count: (\d+)', re.MULTILINE)

_ROS2 = ('.mcap', '.db3')
_READERS: dict[str, type[Ros1Reader] | type[Ros2Reader]] = {
    '.mcap': Ros2Reader,
    '.db3': Ros2Reader,
    '.bag': Ros1Reader,
    '.active': Ros1Reader,  # x.bag.active, of a rosbag that was killed
}
_REPAIRS = {
    '.db3': ' (sqlite3 FILE .recover saves more of a cut one)',
    '.bag': ' (rosbag reindex repairs a cut one)',
    '.active': ' (rosbag reindex repairs a cut one)',
}

Topic = TypeVar('Topic')


def one_line(error: Exception) -> str:
    """Return the message of a library's error in one line that fits a terminal."""
    text = ' '.join(str(error).split()) or 'inconsistent content'
    return text if len(text) <= _LONGEST_REASON else f'{text[:_LONGEST_REASON]} ...'


@dataclass
class BagFile:
    """A file of a bag that is open for reading.

    Attributes:
        path: The file, as messages name it.
        notices: A line for each loss so far.
        damage: The line of the damage at which `messages` ended; empty if it met none.
    """

    path: Path
    reader: Ros1Reader | Ros2Reader
    notices: list[str]
    damage: str = ''

    def messages(
        self, topics: Mapping[tuple[str, str], Topic]
    ) -> Iterator[tuple[Topic, int, bytes]]:
        """Yield topic, receive time (ns) and bytes of each message of topics, in order of time.

        The topics are by their names and types. It ends at the first damage.
        """
        own = [c for c in self.reader.connections if (c.topic, c.msgtype) in topics]
        of_id = {c.id: topics[c.topic, c.msgtype] for c in own}
        count, most = 0, sum(connection.msgcount for connection in own)
        reason = 'some are missing'
        try:
            for connection, time_ns, data in self.reader.messages(own) if own else ():
                # Of a bag that is compressed message by message, which only metadata.yaml tells.
                if data[:4] == _ZSTD_MAGIC and isinstance(self.reader, Ros2Reader):
                    data = zstandard.decompress(data)
                if not isinstance(time_ns, int):  # a text in a damaged database
                    raise TypeError(f'time {time_ns!r}')
                count += 1
                yield of_id[connection.id], time_ns, data
        except Exception as error:  # a damaged file makes any of several libraries fail
            reason = one_line(error)
        damage = f"'{self.path}' is damaged ({reason}): {count:,} of {most:,} messages were read"
        self.damage = damage if count < most else ''


def open_files(path: Path, stack: ExitStack) -> tuple[list[BagFile], list[str]]:
    """Open the files of a bag that can be read, at least one.

    Args:
        path: A rosbag2 folder with or without its metadata.yaml, one of its files, a ROS 1 .bag
            file, or the folder of a run that holds a folder `bag`.
        stack: Closes the files, and removes copies of compressed and damaged ones, in the end.

    Returns:
        The files, and a line for each one that cannot be read, and for missing messages.

    Raises:
        SetcmasError: There is no such path, it is not a bag, or no file of it can be read.
        OSError: A file cannot be read for a reason outside of it.
    """
    if not path.exists():
        raise SetcmasError(f"there is no bag '{path}'; it must be {BAGS}")
    files, losses = [], []
    for file in [path] if path.is_file() else _files(path):
        try:
            files.append(_opened(file, stack))
        except SetcmasError as error:  # of the others there is more
            losses.append(error)
    if not files:
        raise losses[0]
    notices = list(map(str, losses))
    count, nb_listed = sum(file.reader.message_count for file in files), _nb_listed(files[0].path)
    if path.is_dir() and count < nb_listed:
        notices.append(
            f"'{path}' has {count:,} of the {nb_listed:,} messages that its metadata.yaml lists"
        )
    return files, notices


def _files(folder: Path) -> list[Path]:
    """Return the files of a bag: all in its folder, for a killed recorder leaves no list."""
    found: dict[str, Path] = {}
    for file in sorted(folder.iterdir()):
        name = file.name.removesuffix(_PACKED)
        if Path(name).suffix in _ROS2:
            # Who kills rosbag2 while it compresses a file leaves both, the whole one first here.
            found.setdefault(name, file)
    if not found and (folder / 'bag').is_dir():
        return _files(folder / 'bag')
    if not found:
        raise SetcmasError(f"folder '{folder}' is not a bag; it must be {BAGS}")
    return list(found.values())


def _nb_listed(file: Path) -> int:
    """Return the number of messages that the metadata.yaml beside a file lists; 0 without one."""
    try:
        total = _TOTAL.search(read_limited(file.parent / 'metadata.yaml', _MOST_METADATA_BYTES))
    except (FileNotFoundError, SetcmasError):
        return 0
    return int(total[1]) if total else 0


def _opened(file: Path, stack: ExitStack) -> BagFile:
    kind = Path(file.name.removesuffix(_PACKED)).suffix
    if kind not in _READERS:
        raise SetcmasError(f"'{file}' is not a bag; it must be {BAGS}")
    if not file.stat().st_size:
        raise SetcmasError(f"bag '{file}' is empty: nothing was ever written to it")
    source = file
    if file.suffix == _PACKED:
        source = _decompressed(file, _place(stack) / file.stem)
    if kind == '.db3' and any(Path(f'{source}{ending}').exists() for ending in _JOURNALS):
        # The file was not closed: its journal, which rosbags ignores, has some of its content.
        return _copied(file, source, stack)
    try:
        reader = _reader(source, stack)
    except Exception as error:  # a damaged file makes any of several libraries fail
        if kind not in _ROS2:
            raise _unreadable(file, error) from error
        return _copied(file, source, stack)
    return _bag_file(file, reader) if _is_indexed(reader) else _copied(file, source, stack)


def _is_indexed(reader: Ros1Reader | Ros2Reader) -> bool:
    """Return whether a file has all indices; rosbags finds no message of mcap without them."""
    storage = getattr(reader, 'storage', None)
    if not isinstance(storage, McapReader):
        return True
    indexed = sum(sum(chunk.channel_count.values()) for chunk in storage.chunks)
    return indexed == reader.message_count


def _copied(file: Path, source: Path, stack: ExitStack) -> BagFile:
    """Open a copy of what can be read of a damaged or unusual file."""
    from setcmas_tools.bags.damaged_file import copy_of  # late: whole files need no mcap

    copy = _place(stack) / f'copy{source.suffix}'
    try:
        loss = copy_of(source, copy)
        reader = _reader(copy, stack)
    except OSError:
        raise
    except Exception as error:
        raise _unreadable(file, error) from error
    if not loss:
        return _bag_file(file, reader)
    count, duration = reader.message_count, reader.end_time - 1 - reader.start_time
    if not count:
        raise SetcmasError(f"bag '{file}' {loss}: no messages were read")
    read = f'{count:,} messages up to {duration / 1e9:.1f} s were read'
    return BagFile(file, reader, [f"'{file}' {loss}: {read}"])


def _bag_file(file: Path, reader: Ros1Reader | Ros2Reader) -> BagFile:
    nb_lost = reader.message_count - sum(connection.msgcount for connection in reader.connections)
    notices = [f"'{file}' holds no messages"] * (not reader.message_count)
    if nb_lost:
        notices.append(f"'{file}' is damaged: {nb_lost:,} messages belong to no topic")
    return BagFile(file, reader, notices)


def _reader(file: Path, stack: ExitStack) -> Ros1Reader | Ros2Reader:
    reader = _READERS[file.suffix](file)
    reader.open()
    stack.callback(reader.close)
    return reader


def _unreadable(file: Path, error: Exception) -> SetcmasError:
    return SetcmasError(
        f"bag '{file}' cannot be read ({one_line(error)}); it must be whole"
        f'{_REPAIRS.get(file.suffix, "")}'
    )


def _place(stack: ExitStack) -> Path:
    return Path(stack.enter_context(tempfile.TemporaryDirectory(prefix='setcmas_bag_')))


def _decompressed(packed: Path, target: Path) -> Path:
    """Write the content of a compressed file, as far as it goes, into another; return it."""
    error = zstandard.ZstdError('it was cut before the end of its first block')
    with packed.open('rb') as source, target.open('wb') as file:
        try:
            shutil.copyfileobj(zstandard.ZstdDecompressor().stream_reader(source), file)
        except zstandard.ZstdError as reason:
            error = reason
        if not file.tell():
            raise _unreadable(packed, error) from error
    return target
