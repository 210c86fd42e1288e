"""Playback of a bag: the topics to play, a cursor in their messages, and a clock."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Container, Iterator, Sequence
from typing import Any

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.ros.message_class import NoPythonTypeError, message_class
from setcmas_tools.bags.bag import Bag, BagTopic, Message

_NAMES = (topics.PAUSE, topics.RESET, topics.PAUSED.strip('/'), topics.GUARD_STATE)
_OF_FLEETS = (
    topics.BRIDGE_STATE,
    topics.EMERGENCY_STOP,
    topics.EMERGENCY_STOPPED,
    topics.EMULATED_FAULT,
    topics.FLEET_TIME,
    topics.LOCKSTEP,
)
_BEGIN = 'cmd_'  # of any stack: cmd_vel, cmd_vel_wanted, cmd_vel_nav
_COMMAND_TYPES = (
    'ackermann_msgs/msg/AckermannDrive',
    'ackermann_msgs/msg/AckermannDriveStamped',
    'geometry_msgs/msg/Twist',
    'geometry_msgs/msg/TwistStamped',
    'sensor_msgs/msg/Joy',  # its button starts experiments
    'trajectory_msgs/msg/JointTrajectory',
)


def is_command(name: str, msgtype: str) -> bool:
    """Return whether robots or their controllers may act on a topic.

    These topics are never played: no robot may move because of a recording, not even a robot
    that is switched on later. No program acts on cmd_cart_vel, the velocity that a law returned.
    """
    last = name.rpartition('/')[2]
    if msgtype in _COMMAND_TYPES or name in _OF_FLEETS or last in _NAMES:
        return True
    return last.startswith(_BEGIN) and last != topics.CMD_CART_VEL


def chosen_topics(
    bag: Bag, wanted: Sequence[str] | None, own_clock: bool
) -> tuple[dict[BagTopic, Any], list[str]]:
    """Return the message class of each topic to play, and a line for each reason to omit topics.

    Args:
        bag: The bag.
        wanted: Names of the topics to play; None for all.
        own_clock: Whether the player publishes /clock.

    Raises:
        SetcmasError: A wanted topic is not in the bag, or no topic can be played.
    """
    names = {f'/{name.lstrip("/")}' for name in wanted or ()}
    if missing := names - {topic.name for topic in bag.topics}:
        raise SetcmasError(
            f'there is no topic {min(missing)} in the bag; --topics must name topics of it'
        )
    classes: dict[BagTopic, Any] = {}
    left_out: defaultdict[str, list[str]] = defaultdict(list)
    for topic in bag.topics:
        if names and topic.name not in names:
            continue
        reason = _objection(topic, own_clock)
        if any(topic.name == other.name for other in classes):
            reason = reason or 'recorded with two types'
        try:
            classes |= {} if reason else {topic: message_class(topic.type.name)}
        except NoPythonTypeError as error:
            reason = str(error)
        if reason:
            left_out[reason].append(topic.name)
    notes = [f'not played: {_listed(names)} ({why})' for why, names in left_out.items()]
    if not classes:
        raise SetcmasError('; '.join(['no topic is left to play', *notes]))
    return classes, notes


def _objection(topic: BagTopic, own_clock: bool) -> str:
    """Return why a topic is never played; empty if it may be."""
    if is_command(topic.name, topic.type.name):
        return 'no robot moves because of a recording'
    if topic.name in (topics.PARAMETER_EVENTS, topics.ROSOUT):
        return 'they are of the programs that were recorded'
    return '--clock takes its place' if own_clock and topic.name == topics.CLOCK else ''


def _listed(names: list[str]) -> str:
    first = ', '.join(names[:3])
    return f'{first} and {len(names) - 3} more' if len(names) > 3 else first


KEPT = 1000
"""Messages of a latched topic that a late subscriber receives."""

Played = tuple[BagTopic, bytes]


class BagCursor:
    """Reads the messages of some topics up to a time.

    Attributes:
        duration: Time of the last message of the bag in s from its first one.
    """

    def __init__(
        self, bag: Bag, topics: Container[BagTopic], latched: Container[BagTopic]
    ) -> None:
        """Start at the first message.

        Args:
            bag: The bag.
            topics: The topics to read.
            latched: Topics whose older messages count, too.
        """
        self._bag = bag
        self._topics = topics
        self._latched = latched
        self.duration = (bag.end_ns - bag.start_ns) / 1e9
        self._messages: Iterator[Message] = iter(())
        self._next: Message | None = None
        self.move_to(0.0)

    @property
    def next_s(self) -> float | None:
        """Time of the next message in s; None at the end."""
        return (self._next[1] - self._bag.start_ns) / 1e9 if self._next else None

    def until(self, at: float) -> Iterator[Played]:
        """Yield the next messages up to a time in s."""
        while self._next and (self.next_s or 0.0) <= at:
            yield self._taken()

    def move_to(self, at: float) -> list[Played]:
        """Go to the first message from a time in s on.

        Returns:
            The messages of latched topics before it.
        """
        self._messages = (one for one in self._bag.messages() if one[0] in self._topics)
        self._next = next(self._messages, None)
        kept: dict[BagTopic, deque[bytes]] = {}
        while self._next and (self.next_s or 0.0) < at:
            topic, data = self._taken()
            if topic in self._latched:
                kept.setdefault(topic, deque(maxlen=KEPT)).append(data)
        return [(topic, data) for topic, messages in kept.items() for data in messages]

    def _taken(self) -> Played:
        assert self._next
        topic, _, data = self._next
        self._next = next(self._messages, None)
        return topic, data


class PlayClock:
    """The time in s since the first message of a recording.

    Attributes:
        paused: Whether the time stops.
    """

    def __init__(self, rate: float, at: float, now: float) -> None:
        """Start at a time in the recording.

        Args:
            rate: How many times as fast as the steady clock it goes.
            at: Time in the recording in s.
            now: Time of the steady clock in s.
        """
        self.paused = False
        self._rate = rate
        self._at = at
        self._since = now

    def at(self, now: float) -> float:
        """Return the time in the recording at a time of the steady clock."""
        return self._at if self.paused else self._at + self._rate * (now - self._since)

    def wait_s(self, at: float, now: float) -> float:
        """Return the time in s until a time in the recording comes, at least 0."""
        return max(0.0, (at - self.at(now)) / self._rate)

    def toggle(self, now: float) -> None:
        """Pause, or resume."""
        self.move_to(self.at(now), now)
        self.paused = not self.paused

    def move_to(self, at: float, now: float) -> None:
        """Continue from a time in the recording."""
        self._at, self._since = at, now
