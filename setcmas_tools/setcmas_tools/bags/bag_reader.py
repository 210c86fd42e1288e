"""Bags of any kind: their topics, and their messages in the order of time."""

from __future__ import annotations

import contextlib
import heapq
from collections import Counter
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from operator import itemgetter
from pathlib import Path
from typing import Any

from rosbags.interfaces import Connection, ConnectionExtRosbag1, ConnectionExtRosbag2, Qos
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_typestore

from setcmas_simu.errors import SetcmasError, file_errors
from setcmas_simu.fleet import topics
from setcmas_tools.bags.bag_files import BagReader, one_line, open_readers
from setcmas_tools.bags.message_types import UnknownDefinitionError, add_type_of


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
        parts = (self._messages_of(reader, found) for reader in self._readers)
        return heapq.merge(*parts, key=itemgetter(1))

    def _messages_of(
        self, reader: BagReader, found: Mapping[tuple[str, str], BagTopic]
    ) -> Iterator[Message]:
        """Yield the messages of some topics from one reader, up to its first damage."""
        own = [one for one in reader.connections if _key(one) in found]
        count, most = 0, sum(connection.msgcount for connection in own)
        reason = 'some are missing'
        try:
            for connection, time_ns, data in reader.messages(own) if own else ():
                count += 1
                yield found[_key(connection)], time_ns, data
        except Exception as error:  # a damaged file makes any of several libraries fail
            reason = one_line(error)
        if count < most:
            read = f'{count:,} of {most:,} messages were read'
            self._notice(f"'{self.path}' is damaged ({reason}): {read}")

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

    def _notice(self, line: str) -> None:
        if line not in self.notices:  # a bag may be read twice
            self.notices.append(line)


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
        with file_errors(f"bag '{path}' cannot be read"):
            bag = Bag(path, *open_readers(path, stack))
        yield bag


def _is_false(topic: BagTopic, data: bytes) -> bool:
    with contextlib.suppress(SerdeError, AttributeError):  # damaged, or of another type
        return not topic.decode(data).data
    return False


def _key(connection: Connection) -> tuple[str, str]:
    return connection.topic, connection.msgtype
