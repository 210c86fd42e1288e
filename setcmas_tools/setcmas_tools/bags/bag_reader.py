"""Bags of any kind: their topics, and their messages in the order of time."""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from mcap.reader import NonSeekingReader
from mcap.writer import CompressionType
from mcap.writer import Writer as McapFile
from rosbags.highlevel import AnyReader, AnyReaderError
from rosbags.interfaces import Connection, Qos
from rosbags.typesys import Stores, get_typestore

from setcmas_simu.errors import SetcmasError, file_errors
from setcmas_simu.fleet import topics

BAGS = 'a rosbag2 folder, an .mcap or a .db3 file, or a ROS 1 .bag file'
_ENDINGS = ('.mcap', '.db3', '.bag')
_METADATA = 'metadata.yaml'
_LONGEST_REASON = 120


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
            bag = Bag(path, *_opened(path, stack))
        yield bag


@dataclass(frozen=True, eq=False)  # equal only to itself: it is looked up for each message
class BagTopic:
    """A topic of a bag with messages of one type.

    Attributes:
        name: Full name, such as `/tb3_1/odom`.
        msgtype: Type of its messages, such as `nav_msgs/msg/Odometry`.
        decode: Makes a message object from its bytes; raises AnyReaderError.
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
        start_ns: Time of the first message in ns.
        end_ns: Time of the last message in ns.
        notices: A line for each loss; complete once `messages` or `deliver` has ended.
    """

    def __init__(self, path: Path, reader: AnyReader, notices: list[str]) -> None:
        """Resolve the topics of an open reader; `notices` has a line for each loss so far.

        Raises:
            SetcmasError: There is no message, or none of a known type.
        """
        self.path = path
        self.types = reader.typestore
        self.notices = notices
        self._reader = reader
        self._topics = self._resolve()
        if not self._topics:
            reason = self.notices[-1] if self.notices else 'it holds no messages'
            raise SetcmasError(f"bag '{path}' cannot be read: {reason}")
        self.topics = [self._topics[key] for key in sorted(self._topics)]
        self.start_ns = reader.start_time
        self.end_ns = reader.end_time - 1  # rosbags adds a ns

    def _resolve(self) -> dict[tuple[str, str], BagTopic]:
        # Publishers of one topic may have a connection each, and files repeat them.
        connections: dict[tuple[str, str], list[Connection]] = {}
        for connection in self._reader.connections:
            if connection.msgcount:
                connections.setdefault(_key(connection), []).append(connection)
        found = {}
        for (name, msgtype), own in connections.items():
            if msgtype not in self.types.fielddefs:
                self.notices.append(
                    f'topic {name} ({msgtype}) is left out: the bag has no definition of its type'
                )
                continue
            found[name, msgtype] = BagTopic(
                f'/{name.lstrip("/")}',  # ROS 1 has names without a slash
                msgtype,
                partial(self._reader.deserialize, typ=msgtype),
                sum(one.msgcount for one in own),
                tuple(getattr(own[0].ext, 'offered_qos_profiles', ())),  # none in ROS 1
            )
        return found

    def messages(self, chosen: Container[BagTopic] | None = None) -> Iterator[Message]:
        """Yield topic, receive time (ns) and bytes of each message up to the first damage.

        They are in the order of time.
        """
        found = {k: one for k, one in self._topics.items() if chosen is None or one in chosen}
        own = [one for one in self._reader.connections if _key(one) in found]
        if not own:  # rosbags would yield all messages
            return
        try:
            for connection, time_ns, data in self._reader.messages(own):
                yield found[_key(connection)], time_ns, data
        except Exception as error:  # a damaged file makes any of several libraries fail
            line = f"'{self.path}' is damaged ({_one_line(error)}): later messages are missing"
            if line not in self.notices:
                self.notices.append(line)

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
            except AnyReaderError as error:
                wrong[topic] += 1
                reasons[topic] = _one_line(error)
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


def _is_false(topic: BagTopic, data: bytes) -> bool:
    with suppress(AnyReaderError, AttributeError):  # damaged, or of another type
        return not topic.decode(data).data
    return False


def _key(connection: Connection) -> tuple[str, str]:
    return connection.topic, connection.msgtype


def _one_line(error: Exception) -> str:
    """Return the message of a library's error in one line that fits a terminal."""
    text = ' '.join(str(error).split()) or 'inconsistent content'
    return text if len(text) <= _LONGEST_REASON else f'{text[:_LONGEST_REASON]} ...'


def _opened(path: Path, stack: ExitStack) -> tuple[AnyReader, list[str]]:
    """Open a bag, or copies of its mcap files up to their damage; return a line for each loss.

    `stack` closes the reader at the end, and removes the copies.

    Raises:
        SetcmasError: There is no such path, it is not a bag, or no message can be read.
        OSError: A file cannot be read for another reason than its content.
    """
    if not path.exists():
        raise SetcmasError(f"there is no bag '{path}'; it must be {BAGS}")
    files = [path] if path.is_file() else sorted(path.iterdir())
    files = [file for file in files if file.suffix in _ENDINGS]
    was_closed = (path / _METADATA).is_file()
    if not files and not was_closed:
        if (path / 'bag').is_dir():
            return _opened(path / 'bag', stack)
        raise SetcmasError(f"'{path}' is not a bag; it must be {BAGS}")
    # Bags hold definitions since Iron (mcap: Humble), so those without are Humble's or older.
    read = partial(AnyReader, default_typestore=get_typestore(Stores.ROS2_HUMBLE))
    try:
        return stack.enter_context(read([path] if was_closed else files)), []
    except Exception as error:  # a damaged file makes any of several libraries fail
        reason = _one_line(error)
    recordings = [file for file in files if file.suffix == '.mcap']
    if not recordings:
        raise SetcmasError(f"bag '{path}' cannot be read ({reason}); it must be whole")
    folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix='setcmas_bag_')))
    copies = [folder / file.name for file in recordings]
    cut = [own for own, copy in zip(recordings, copies, strict=True) if not _copied(own, copy)]
    loss = ', '.join(f"'{file}' is cut short or damaged" for file in cut)
    loss = loss or f"'{path}' is damaged ({reason})"
    reader = stack.enter_context(read(copies))
    if not reader.message_count:
        raise SetcmasError(f'{loss}: no messages were read')
    seconds = (reader.end_time - 1 - reader.start_time) / 1e9
    return reader, [f'{loss}: {reader.message_count:,} messages up to {seconds:.1f} s were read']


def _copied(damaged: Path, target: Path) -> bool:
    """Copy an mcap file up to the first damage; return whether it has none."""
    channels: dict[int, int] = {}
    with damaged.open('rb') as source, target.open('wb') as file:
        writer = McapFile(file, compression=CompressionType.NONE)
        writer.start(profile='ros2')
        # A length beyond the file is garbage.
        size = damaged.stat().st_size
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
            return False
        finally:
            writer.finish()
    return True
