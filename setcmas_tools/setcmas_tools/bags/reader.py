"""Reader of bags of any kind: their topics, and their messages in the order of time."""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from rosbags.interfaces import Connection, Qos

from setcmas_simu.errors import SetcmasError
from setcmas_tools.bags.derived import is_derived
from setcmas_tools.bags.files import open_sources
from setcmas_tools.bags.source import BagSource
from setcmas_tools.bags.types import BagTypes, MessageType, UnresolvedTypeError


@dataclass(frozen=True, eq=False)  # equal only to itself: it is looked up for each message
class BagTopic:
    """A topic of a bag and how its messages are decoded; there is one for each of its types.

    Attributes:
        name: Full name, such as `/tb3_1/odom`.
        type: Type of its messages.
        count: How many of them the bag holds.
        derived: Whether a recorder has made them from other messages of this bag.
        offered_qos: Quality of service of its publishers, as far as the bag tells.
    """

    name: str
    type: MessageType
    count: int
    derived: bool = False
    offered_qos: tuple[Qos, ...] = ()


class Bag:
    """A bag that is open for reading.

    Attributes:
        topics: Those with messages whose type is known, sorted by name.
        count: Number of messages of these topics.
        start_ns: Time of the first message in ns.
        end_ns: Time of the last message in ns.
    """

    def __init__(self, path: Path, sources: list[BagSource]) -> None:
        """Resolve the topics of open files.

        Raises:
            SetcmasError: There is no message, or none of a known type.
        """
        full = [source for source in sources if source.extent.count]
        if not full:
            losses = [notice for source in sources for notice in source.notices]
            raise SetcmasError(losses[0] if losses else f"bag '{path}' holds no messages")
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
        """A line for each thing that cannot be read; complete once `messages` has ended."""
        return self._left_out + [n for source in self._sources for n in source.notices]

    def messages(self) -> Iterator[tuple[BagTopic, int, bytes]]:
        """Yield topic, receive time (ns) and bytes of each message, file after file."""
        for source in self._sources:
            topics = {c.id: self._topics.get(_key(c)) for c in source.connections}
            for connection, time_ns, data in source.messages():
                if topic := topics[connection.id]:
                    yield topic, time_ns, data

    def _resolve(self) -> dict[tuple[str, str], BagTopic]:
        connections: dict[tuple[str, str], Connection] = {}
        counts: Counter[tuple[str, str]] = Counter()
        for connection in (c for source in self._sources for c in source.connections):
            # Publishers of one topic may have a connection each, and files repeat them.
            connections.setdefault(_key(connection), connection)
            counts[_key(connection)] += connection.msgcount
        types = BagTypes()
        topics = {}
        for key, connection in connections.items():
            try:
                message_type = types.resolve(connection)
            except UnresolvedTypeError as error:
                if counts[key]:
                    self._left_out.append(f'topic {key[0]} ({key[1]}) is left out: {error}')
            else:
                offered = getattr(connection.ext, 'offered_qos_profiles', ())  # none in ROS 1
                topics[key] = BagTopic(
                    key[0], message_type, counts[key], is_derived(connection), tuple(offered)
                )
        return {key: topic for key, topic in topics.items() if topic.count}


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
            bag = Bag(path, open_sources(path, stack))
        except OSError as error:
            raise SetcmasError(f"bag '{path}' cannot be read: {error.strerror}") from error
        yield bag


def _key(connection: Connection) -> tuple[str, str]:
    return connection.topic, connection.msgtype
