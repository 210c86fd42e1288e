"""Bags of any kind: their topics, and their messages in the order of time."""

from __future__ import annotations

import heapq
import tempfile
from collections import Counter
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from operator import itemgetter
from pathlib import Path, PurePath
from typing import Any, TypeAlias

import yaml
from rosbags.interfaces import Connection, ConnectionExtRosbag1, ConnectionExtRosbag2, Qos
from rosbags.rosbag1 import Reader as Ros1Reader
from rosbags.rosbag2 import Reader as Ros2Reader
from rosbags.rosbag2.storage_mcap import McapReader
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_typestore

from setcmas_simu.errors import SetcmasError, file_errors
from setcmas_simu.fleet import topics
from setcmas_tools.bags.bag_writer import copy_of_mcap
from setcmas_tools.bags.message_types import UnknownDefinitionError, add_type_of, one_line

BAGS = 'a rosbag2 folder, an .mcap or a .db3 file, or a ROS 1 .bag file'
_ROS2 = ('.mcap', '.db3', '.zstd')
_ROS1 = '.bag'
_REPAIRS = {
    '.db3': 'sqlite3 FILE .recover recovers a damaged one',
    '.bag': 'rosbag reindex recovers a damaged one',
    '.zstd': 'zstd -d FILE unpacks it',
}

BagReader: TypeAlias = Ros1Reader | Ros2Reader


class _Part:
    """Messages of some topics from one reader of a bag, up to its first damage.

    Attributes:
        loss: Why some are missing, once all others were read; '' if none are.
    """

    def __init__(self, reader: BagReader, found: Mapping[tuple[str, str], BagTopic]) -> None:
        self.loss = ''
        self._reader, self._found = reader, found

    def messages(self) -> Iterator[Message]:
        """Yield topic, receive time (ns) and bytes of each message."""
        own = [one for one in self._reader.connections if _key(one) in self._found]
        count, most = 0, sum(connection.msgcount for connection in own)
        reason = 'some are missing'
        try:
            for connection, time_ns, data in self._reader.messages(own) if own else ():
                count += 1
                yield self._found[_key(connection)], time_ns, data
        except Exception as error:  # a damaged file makes any of several libraries fail
            reason = one_line(error)
        if count < most:
            self.loss = reason


@contextmanager
def open_bag(path: Path) -> Iterator[Bag]:
    """Open a bag for reading, healthy or cut short.

    Args:
        path: A rosbag2 folder with or without its metadata.yaml, an .mcap or a .db3 file, a
            ROS 1 .bag file, or the folder of a run that holds a folder `bag`.

    Raises:
        SetcmasError: There is no such path, it is not a bag, or no message in it can be read.
    """
    with ExitStack() as stack:
        with file_errors(f"bag '{path}' cannot be read"):
            bag = Bag(path, *_open_readers(path, stack))
        yield bag


@dataclass(frozen=True, eq=False)  # equal only to itself: it is looked up for each message
class BagTopic:
    """A topic of a bag with messages of one type.

    Attributes:
        name: Full name, such as `/tb3_1/odom`.
        msgtype: Type of its messages, such as `nav_msgs/msg/Odometry`.
        decode: Makes a message object from its bytes; raises SerdeError.
        count: Number of messages in the bag.
        offered_qos: Quality of service of its publishers, if the bag stores it.
    """

    name: str
    msgtype: str
    decode: Callable[[bytes], Any]
    count: int
    offered_qos: tuple[Qos, ...] = ()


Taker = Callable[[int, Any], None]
"""Takes the time of a message in ns from t = 0 of the run, and the message."""

Message = tuple[BagTopic, int, bytes]
"""Topic, receive time in ns, and the serialised message."""


class Bag:
    """A bag that is open for reading.

    Attributes:
        path: As the user gave it.
        types: The types of its messages and of their parts.
        topics: Those with messages whose type is known, sorted by name.
        count: Number of messages of these topics.
        start_ns: Time of the first message in ns.
        end_ns: Time of the last message in ns.
        notices: A line for each loss; complete once `messages` or `deliver` has ended.
    """

    def __init__(self, path: Path, readers: list[BagReader], notices: list[str]) -> None:
        """Resolve the topics of open readers; `notices` has a line for each loss so far.

        Raises:
            SetcmasError: There is no message, or none of a known type.
        """
        self.path = path
        self.types = get_typestore(Stores.EMPTY)
        self.notices = notices
        self._is_damaged = False
        self._readers = [reader for reader in readers if reader.message_count]
        self._topics = self._resolve()
        if not self._topics:
            reason = self.notices[-1] if self.notices else 'it holds no messages'
            raise SetcmasError(f"bag '{path}' cannot be read: {reason}")
        self.topics = [self._topics[key] for key in sorted(self._topics)]
        self.count = sum(topic.count for topic in self.topics)
        self.start_ns = min(reader.start_time for reader in self._readers)
        self.end_ns = max(reader.end_time for reader in self._readers) - 1  # rosbags adds a ns

    def messages(self, chosen: Container[BagTopic] | None = None) -> Iterator[Message]:
        """Yield topic, receive time (ns) and bytes of each message in the order of time."""
        found = {k: one for k, one in self._topics.items() if chosen is None or one in chosen}
        parts = [_Part(reader, found) for reader in self._readers]
        yield from heapq.merge(*(part.messages() for part in parts), key=itemgetter(1))
        if any(part.loss for part in parts) and not self._is_damaged:
            self._is_damaged = True
            self.notices.append(self._damage())

    def _damage(self) -> str:
        """Return how much of a damaged bag can be read, the same whichever topics were wanted."""
        parts = [_Part(reader, self._topics) for reader in self._readers]
        count = sum(1 for part in parts for _ in part.messages())
        reasons = '; '.join(dict.fromkeys(part.loss for part in parts if part.loss))
        read = f'{count:,} of {self.count:,} messages were read'
        return f"'{self.path}' is damaged ({reasons}): {read}"

    def deliver(self, takers: Mapping[BagTopic, Sequence[Taker]]) -> None:
        """Decode the messages of some topics, and hand them to functions.

        A topic without functions is not decoded. Messages that cannot be decoded get a notice.
        """
        zero_ns = self._first_command()
        wrong: Counter[BagTopic] = Counter()
        reasons: dict[BagTopic, str] = {}
        for topic, time_ns, data in self.messages({one for one, own in takers.items() if own}):
            try:
                message = topic.decode(data)
            except SerdeError as error:
                wrong[topic] += 1
                reasons[topic] = one_line(error)
                continue
            for take in takers[topic]:
                take(time_ns - zero_ns, message)
        self.notices += [
            f'topic {topic.name}: {number:,} of {topic.count:,} messages are left out, '
            f'their bytes are not a {topic.msgtype} ({reasons[topic]})'
            for topic, number in wrong.items()
        ]

    def _first_command(self) -> int:
        """Return the time of the first command in ns, else of the first message: t = 0 of the run.

        In an experiment, where zeros are sent from the beginning, it is its start.
        """
        # A recording of `setcmas play` has no commands but the velocities that laws returned.
        kinds = (topics.CMD_VEL, topics.CMD_CART_VEL)
        commands = next(filter(None, (self._of_robots(kind) for kind in kinds)), set())
        pauses = {topic for topic in self.topics if topic.name == topics.PAUSED}
        first: int | None = None
        for topic, time_ns, data in self.messages(commands | pauses):
            if topic in commands and first is None:
                first = time_ns
            if (first is not None and not pauses) or (topic in pauses and _is_false(topic, data)):
                return time_ns
        return self.start_ns if first is None else first

    def _of_robots(self, kind: str) -> set[BagTopic]:
        robots = ((topic, topics.robot_of(topic.name)) for topic in self.topics)
        return {one for one, i in robots if i and one.name == topics.robot_topic(i, kind)}

    def _resolve(self) -> dict[tuple[str, str], BagTopic]:
        connections: dict[tuple[str, str], Connection] = {}
        counts: Counter[tuple[str, str]] = Counter()
        for connection in (one for reader in self._readers for one in reader.connections):
            # Publishers of one topic may have a connection each, and files repeat them.
            connections.setdefault(_key(connection), connection)
            counts[_key(connection)] += connection.msgcount
        found = {}
        for key, count in (+counts).items():
            try:
                found[key] = self._topic(connections[key], count)
            except UnknownDefinitionError as error:
                self.notices.append(f'topic {key[0]} ({key[1]}) is left out: {error}')
        return found

    def _topic(self, connection: Connection, count: int) -> BagTopic:
        """Return a topic, or raise UnknownDefinitionError."""
        ext = connection.ext
        is_ros1 = isinstance(ext, ConnectionExtRosbag1)
        if isinstance(ext, ConnectionExtRosbag2) and ext.serialization_format != 'cdr':
            raise UnknownDefinitionError(
                f"it is encoded as '{ext.serialization_format}'; it must be cdr"
            )
        add_type_of(connection, self.types, is_ros1)
        deserialise = self.types.deserialize_ros1 if is_ros1 else self.types.deserialize_cdr
        return BagTopic(
            f'/{connection.topic.lstrip("/")}',  # ROS 1 has names without a slash
            connection.msgtype,
            partial(deserialise, typename=connection.msgtype),
            count,
            tuple(getattr(ext, 'offered_qos_profiles', ())),  # none in ROS 1
        )


def _is_false(topic: BagTopic, data: bytes) -> bool:
    with suppress(SerdeError, AttributeError):  # damaged, or of another type
        return not topic.decode(data).data
    return False


def _key(connection: Connection) -> tuple[str, str]:
    return connection.topic, connection.msgtype


def _open_readers(path: Path, stack: ExitStack) -> tuple[list[BagReader], list[str]]:
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
        return _open_readers(path / 'bag', stack)
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
    loss = copy_of_mcap(file, copy)
    reader = _opened(copy, stack)
    if not loss:
        return reader, ''
    count, duration = reader.message_count, reader.end_time - 1 - reader.start_time
    if not count:
        raise SetcmasError(f"bag '{file}' {loss}: no messages were read")
    return reader, f"'{file}' {loss}: {count:,} messages up to {duration / 1e9:.1f} s were read"
