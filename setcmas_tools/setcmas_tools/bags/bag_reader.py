"""Bags of any kind: their files, their topics, and their messages in the order of time."""

from __future__ import annotations

import contextlib
import heapq
from collections import Counter
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from pathlib import Path
from typing import Any

from rosbags.interfaces import Connection, Qos

from setcmas_simu.errors import SetcmasError, file_errors
from setcmas_simu.fleet import topics
from setcmas_tools.bags.bag_file import BagFile, open_files
from setcmas_tools.bags.message_types import (
    BagTypes,
    MessageType,
    UndecodableError,
    UnresolvedTypeError,
)

_LONGEST_NS = 10**15
"""A recording lasts less than these 11 days, unless the clock was set during it."""


@dataclass(frozen=True, eq=False)  # equal only to itself: it is looked up for each message
class BagTopic:
    """A topic of a bag with messages of one type, and how they are decoded.

    Attributes:
        name: Full name, such as `/tb3_1/odom`.
        type: Type of its messages.
        count: Number of messages in the bag.
        offered_qos: Quality of service of its publishers, if the bag stores it.
    """

    name: str
    type: MessageType
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
        topics: Those with messages whose type is known, sorted by name.
        count: Number of messages of these topics.
        start_ns: Time of the first message in ns.
        end_ns: Time of the last message in ns.
    """

    def __init__(self, path: Path, files: list[BagFile], notices: list[str]) -> None:
        """Resolve the topics of open files; `notices` has a line for each loss so far.

        Raises:
            SetcmasError: There is no message, or none of a known type.
        """
        self.path = path
        self._files = files
        self._notices = notices
        self._undecodable: dict[BagTopic, str] = {}
        self._topics = self._resolve()
        full = [file.reader for file in files if file.reader.message_count]
        if not self._topics:
            lines = self._notices + [line for file in files for line in file.notices]
            raise SetcmasError(f"bag '{path}' cannot be read: {lines[-1]}")
        self.topics = [self._topics[key] for key in sorted(self._topics)]
        self.count = sum(topic.count for topic in self.topics)
        self.start_ns = min(reader.start_time for reader in full)
        self.end_ns = max(reader.end_time for reader in full) - 1  # rosbags counts a ns more
        self._of_one_clock: range | None = None
        if self.end_ns - self.start_ns > _LONGEST_NS:
            self._keep_one_clock()

    @property
    def notices(self) -> list[str]:
        """A line for each loss; complete once `messages` or `deliver` has ended."""
        files = [line for file in self._files for line in (*file.notices, file.damage) if line]
        undecodable = [self._undecodable[t] for t in self.topics if t in self._undecodable]
        return self._notices + files + undecodable

    def messages(self, chosen: Container[BagTopic] | None = None) -> Iterator[Message]:
        """Yield topic, receive time (ns) and bytes of each message in the order of time."""
        found = {k: one for k, one in self._topics.items() if chosen is None or one in chosen}
        merged = heapq.merge(*(file.messages(found) for file in self._files), key=itemgetter(1))
        kept = self._of_one_clock
        return merged if kept is None else (one for one in merged if one[1] in kept)

    def _keep_one_clock(self) -> None:
        """Leave out the messages before a clock was set, or after, whichever are fewer."""
        times = [time_ns for _, time_ns, _ in self.messages()]
        early = [time_ns for time_ns in times if time_ns - times[0] <= _LONGEST_NS]
        late = [time_ns for time_ns in times if times[-1] - time_ns <= _LONGEST_NS]
        kept = max(early, late, key=len)
        if len(kept) == len(times):  # the others are of topics that are left out
            return
        self.start_ns, self.end_ns = kept[0], kept[-1]
        self._of_one_clock = range(self.start_ns, self.end_ns + 1)
        self.count = len(kept)
        self._notices.append(
            f'{len(times) - len(kept):,} of {len(times):,} messages are left out: the clock was '
            f'set during the recording, by {(late[0] - early[-1]) / 1e9:,.0f} s'
        )

    def deliver(self, takers: Mapping[BagTopic, Sequence[Taker]], zero_ns: int) -> None:
        """Decode the messages of some topics, and hand them to functions; t = 0 at `zero_ns`.

        A topic without functions is not decoded. Messages that cannot be decoded get a notice.
        """
        wrong: dict[BagTopic, int] = {}
        for topic, time_ns, data in self.messages({one for one, own in takers.items() if own}):
            try:
                message = topic.type.decode(data)
                for take in takers[topic]:
                    take(time_ns - zero_ns, message)
            except UndecodableError as error:
                wrong[topic] = wrong.get(topic, 0) + 1
                self._undecodable[topic] = (
                    f'topic {topic.name}: {wrong[topic]:,} of {topic.count:,} messages are '
                    f'left out, their bytes are not a {topic.type.name} ({error})'
                )

    def first_command(self) -> int:
        """Return the time of the first command in ns, else of the first message.

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
        for connection in (c for file in self._files for c in file.reader.connections):
            # Publishers of one topic may have a connection each, and files repeat them.
            connections.setdefault(_key(connection), connection)
            counts[_key(connection)] += connection.msgcount
        types = BagTypes()
        found = {}
        for key, count in (+counts).items():
            connection = connections[key]
            name = f'/{key[0].lstrip("/")}'  # ROS 1 has names without a slash
            try:
                message_type = types.resolve(connection)
            except UnresolvedTypeError as error:
                self._notices.append(f'topic {name} ({key[1]}) is left out: {error}')
            else:
                offered = getattr(connection.ext, 'offered_qos_profiles', ())  # none in ROS 1
                found[key] = BagTopic(name, message_type, count, tuple(offered))
        return found


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
            bag = Bag(path, *open_files(path, stack))
        yield bag


def _is_false(topic: BagTopic, data: bytes) -> bool:
    with contextlib.suppress(UndecodableError, AttributeError):  # damaged, or of another type
        return not topic.type.decode(data).data
    return False


def _key(connection: Connection) -> tuple[str, str]:
    return connection.topic, connection.msgtype
