"""Bags of any kind: their files, their topics, and their messages in the order of time."""

from __future__ import annotations

import contextlib
import re
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rosbags.interfaces import Connection, Qos
from rosbags.rosbag1 import Reader as Ros1Reader
from rosbags.rosbag2 import Reader as Ros2Reader

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.limited_file import read_limited
from setcmas_tools.bags.bag_limits import decompress_file, too_large, zstd_content
from setcmas_tools.bags.bag_sources import BagSource, IndexedSource, McapSource, one_line
from setcmas_tools.bags.message_types import (
    BagTypes,
    MessageType,
    UndecodableError,
    UnresolvedTypeError,
)

_MOST_METADATA_BYTES = 1_000_000
_BAGS = 'a rosbag2 folder, an .mcap or a .db3 file, or a ROS 1 .bag file'
_REINDEX = 'it must be whole (rosbag reindex repairs a cut one)'
_ADVICE = {
    '.db3': 'it must be whole (sqlite3 FILE .recover saves a cut one), with no #, ? or % in its '
    'path',
    '.bag': _REINDEX,
    '.active': _REINDEX,  # x.bag.active, of a rosbag that was killed
}


def open_sources(path: Path, stack: ExitStack) -> tuple[list[BagSource], bool]:
    """Open the files of a bag.

    Args:
        path: A rosbag2 folder with or without its metadata.yaml, an .mcap or a .db3 file, a
            ROS 1 .bag file, or the folder of a run that holds a folder `bag`.
        stack: Closes the files in the end.

    Returns:
        One source for each file that can be read, at least one; and whether their messages are
        compressed one by one.

    Raises:
        SetcmasError: There is no such path, it is not a bag, or no file of it can be read.
        OSError: A file cannot be read for a reason outside of it.
    """
    if not path.exists():
        raise SetcmasError(f"there is no bag '{path}'; it must be {_BAGS}")
    sources, failures = [], []
    mode = _compression(path) if path.is_dir() else ''
    files = _unpacked(path, stack) if mode == 'file' else _files(path)
    for file in files:
        try:
            source = _open_file(file)
        except SetcmasError as error:
            failures.append(error)
        else:
            stack.callback(source.close)
            sources.append(source)
    if not sources:
        raise failures[0]
    # Only of a bag in several files, whose recorder was killed just after it began a new one.
    sources[0].notices[:0] = map(str, failures)
    return sources, mode == 'message'


def _files(path: Path) -> list[Path]:
    if path.is_file():
        return [path]
    # metadata.yaml is not needed: it is missing after a kill, and slower to parse than the files.
    files = [file for file in sorted(path.iterdir()) if file.suffix in ('.mcap', '.db3')]
    if not files and (path / 'bag').is_dir():
        return _files(path / 'bag')
    if not files:
        raise SetcmasError(f"folder '{path}' is not a bag; it must be {_BAGS}")
    return files


def _compression(folder: Path) -> str:
    """Return 'file' or 'message' of a compressed bag, else nothing."""
    try:
        metadata = read_limited(folder / 'metadata.yaml', _MOST_METADATA_BYTES)
    except FileNotFoundError:
        return ''
    found = re.search(
        rb'^\s*compression_mode:\s*[\'"]?(file|message)', metadata, re.IGNORECASE | re.MULTILINE
    )
    return found[1].decode().lower() if found else ''


def _unpacked(folder: Path, stack: ExitStack) -> list[Path]:
    """Return the files of a bag that is compressed as a whole, in a temporary folder."""
    packed = sorted(folder.glob('*.zstd'))
    if not packed:
        raise SetcmasError(f"folder '{folder}' is not a bag; it must be {_BAGS}")
    place = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix='setcmas_bag_')))
    return [decompress_file(file, place / file.stem) for file in packed]


def _open_file(file: Path) -> BagSource:
    if file.suffix not in ('.mcap', *_ADVICE):
        raise SetcmasError(f"'{file}' is not a bag; it must be {_BAGS}")
    if not file.stat().st_size:
        raise SetcmasError(f"bag '{file}' is empty: nothing was ever written to it")
    if file.suffix == '.mcap':
        return McapSource(file)
    if Path(f'{file}-wal').exists():  # of a .db3 file; rosbags ignores it
        raise SetcmasError(
            f"bag '{file}' was not closed; this closes it: "
            f"sqlite3 '{file}' 'PRAGMA journal_mode=DELETE'"
        )
    return _open_whole(file)


def _open_whole(file: Path) -> BagSource:
    """Open a file that cannot be salvaged."""
    reader = Ros2Reader if file.suffix == '.db3' else Ros1Reader
    try:
        return IndexedSource(file, reader(file))
    except SetcmasError:
        raise
    except Exception as error:  # a damaged file makes any of several libraries fail
        advice = _ADVICE[file.suffix]
        raise SetcmasError(f"bag '{file}' cannot be read ({one_line(error)}); {advice}") from error


DERIVED = '# The recorder of setcmas made these messages from the odometry in this bag.\n'
"""First line of their definition: a comment, which leaves the type's hash as it is."""


@dataclass(frozen=True, eq=False)  # equal only to itself: it is looked up for each message
class BagTopic:
    """A topic of a bag with messages of one type, and how they are decoded.

    Attributes:
        name: Full name, such as `/tb3_1/odom`.
        type: Type of its messages.
        count: Number of messages in the bag.
        derived: Whether the recorder made the messages from others in this bag.
        offered_qos: Quality of service of its publishers, if the bag stores it.
    """

    name: str
    type: MessageType
    count: int
    derived: bool = False
    offered_qos: tuple[Qos, ...] = ()


Taker = Callable[[int, Any], None]
"""Takes the time of a message in ns from t = 0 of the run, and the message."""

Message = tuple[BagTopic, int, bytes]
"""Topic, receive time in ns, and the serialised message."""

Progress = Callable[[Iterator[Message]], Iterator[Message]]


class Bag:
    """A bag that is open for reading.

    Attributes:
        path: As the user gave it.
        topics: Those with messages whose type is known, sorted by name.
        count: Number of messages of these topics.
        start_ns: Time of the first message in ns.
        end_ns: Time of the last message in ns.
    """

    def __init__(self, path: Path, sources: list[BagSource], compressed: bool) -> None:
        """Resolve the topics of open files, whose messages may be compressed one by one.

        Raises:
            SetcmasError: There is no message, or none of a known type.
        """
        full = [source for source in sources if source.extent.count]
        if not full:
            losses = [notice for source in sources for notice in source.notices]
            raise SetcmasError(losses[0] if losses else f"bag '{path}' holds no messages")
        self.path = path
        self._compressed = compressed
        self._sources = sorted(full, key=lambda source: source.extent.start_ns)
        self._left_out: list[str] = []
        self._topics = self._resolve()
        if not self._topics:
            reason = (self._left_out or ['its messages belong to no topic'])[0]
            raise SetcmasError(f"bag '{path}' cannot be read: {reason}")
        self.topics = [self._topics[key] for key in sorted(self._topics)]
        self.count = sum(topic.count for topic in self.topics)
        self.start_ns = min(source.extent.start_ns for source in full)
        self.end_ns = max(source.extent.end_ns for source in full)

    @property
    def notices(self) -> list[str]:
        """A line for each loss; complete once `messages` has ended."""
        return self._left_out + [n for source in self._sources for n in source.notices]

    def messages(self) -> Iterator[Message]:
        """Yield topic, receive time (ns) and bytes of each message, file after file.

        Raises:
            SetcmasError: They take far more bytes than the files.
        """
        most = left = sum(source.most_bytes for source in self._sources)
        for source in self._sources:
            by_id = {c.id: self._topics.get(_key(c)) for c in source.connections}
            for connection, time_ns, content in source.messages():
                data = _decompressed(content) if self._compressed else content
                left -= len(data)
                if left < 0:
                    raise too_large(self.path, 'more bytes of messages than its size allows', most)
                if topic := by_id[connection.id]:
                    yield topic, time_ns, data

    def deliver(
        self, takers: Mapping[BagTopic, Sequence[Taker]], zero_ns: int, shown: Progress = iter
    ) -> list[str]:
        """Decode the messages of some topics, and hand them to functions.

        Args:
            takers: The functions by topic; a topic without any is not decoded.
            zero_ns: The receive time that is t = 0.
            shown: Shows the progress of an iterator.

        Returns:
            A line for each topic with messages that cannot be decoded.
        """
        wrong: dict[BagTopic, int] = {}
        lines = {}
        for topic, time_ns, data in shown(self.messages()):
            if own := takers.get(topic):
                try:
                    message = topic.type.decode(data)
                    for take in own:
                        take(time_ns - zero_ns, message)
                except UndecodableError as error:
                    wrong[topic] = wrong.get(topic, 0) + 1
                    lines[topic] = (
                        f'topic {topic.name}: {wrong[topic]:,} of {topic.count:,} messages are '
                        f'left out, their bytes are not a {topic.type.name} ({error})'
                    )
        return [lines[topic] for topic in self.topics if topic in lines]

    def first_command(self, names: Mapping[str, str]) -> int:
        """Return the time of the first command in ns, else of the first message.

        In an experiment, where zeros are sent from the beginning, it is its start.

        Args:
            names: Topics by their names in the bag, for robots with names of their own.
        """
        # A recording of `setcmas play` has no commands but the velocities that laws returned.
        kinds = (topics.CMD_VEL, topics.CMD_CART_VEL)
        commands = next(filter(None, (self._of_robots(kind, names) for kind in kinds)), set())
        pauses = {topic for topic in self.topics if topic.name == topics.PAUSED}
        first: int | None = None
        for topic, time_ns, data in self.messages() if commands or pauses else ():
            if topic in commands and first is None:
                first = time_ns
            if (first is not None and not pauses) or (topic in pauses and _is_false(topic, data)):
                return time_ns
        return self.start_ns if first is None else first

    def _of_robots(self, kind: str, names: Mapping[str, str]) -> set[BagTopic]:
        named = ((topic, names.get(topic.name, topic.name)) for topic in self.topics)
        robots = ((topic, name, topics.robot_of(name)) for topic, name in named)
        return {topic for topic, name, i in robots if i and name == topics.robot_topic(i, kind)}

    def _resolve(self) -> dict[tuple[str, str], BagTopic]:
        connections: dict[tuple[str, str], Connection] = {}
        counts: Counter[tuple[str, str]] = Counter()
        for connection in (c for source in self._sources for c in source.connections):
            # Publishers of one topic may have a connection each, and files repeat them.
            connections.setdefault(_key(connection), connection)
            counts[_key(connection)] += connection.msgcount
        types = BagTypes()
        found = {}
        for key, connection in connections.items():
            try:
                message_type = types.resolve(connection)
            except UnresolvedTypeError as error:
                if counts[key]:
                    self._left_out.append(f'topic {key[0]} ({key[1]}) is left out: {error}')
            else:
                offered = getattr(connection.ext, 'offered_qos_profiles', ())  # none in ROS 1
                derived = connection.msgdef.data.startswith(DERIVED)
                found[key] = BagTopic(key[0], message_type, counts[key], derived, tuple(offered))
        return {key: topic for key, topic in found.items() if topic.count}


@contextlib.contextmanager
def open_bag(path: Path) -> Iterator[Bag]:
    """Open a bag for reading, healthy or cut short.

    Args:
        path: A rosbag2 folder with or without its metadata.yaml, an .mcap or a .db3 file, a
            ROS 1 .bag file, or the folder of a run that holds a folder `bag`.

    Raises:
        SetcmasError: There is no such path, it is not a bag, or no message in it can be read.
    """
    with contextlib.ExitStack() as stack:
        try:
            bag = Bag(path, *open_sources(path, stack))
        except OSError as error:
            raise SetcmasError(f"bag '{path}' cannot be read: {error.strerror}") from error
        yield bag


def _is_false(topic: BagTopic, data: bytes) -> bool:
    with contextlib.suppress(UndecodableError, AttributeError):  # damaged, or of another type
        return not topic.type.decode(data).data
    return False


def _decompressed(message: bytes) -> bytes:
    with contextlib.suppress(Exception):  # of the decompressor
        return zstd_content(message)
    return b''


def _key(connection: Connection) -> tuple[str, str]:
    return connection.topic, connection.msgtype
