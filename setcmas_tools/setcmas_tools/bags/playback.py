"""Playback of a bag: the topics to play, a cursor in their messages, and a clock."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Container, Iterator
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


def played_topics(bag: Bag, own_clock: bool) -> tuple[dict[BagTopic, Any], list[str]]:
    """Return the message class of each topic to play, and a line for each reason to omit topics.

    Args:
        bag: The bag.
        own_clock: Whether the player publishes /clock.

    Raises:
        SetcmasError: No topic can be played.
    """
    classes: dict[BagTopic, Any] = {}
    left_out: defaultdict[str, list[str]] = defaultdict(list)
    for topic in bag.topics:
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
        return 'they belong to the recorded programs'
    return '--clock takes its place' if own_clock and topic.name == topics.CLOCK else ''


def _listed(names: list[str]) -> str:
    first = ', '.join(names[:3])
    return f'{first} and {len(names) - 3} more' if len(names) > 3 else first


Played = tuple[BagTopic, bytes]


class BagCursor:
    """Reads the messages of some topics up to a time.

    Attributes:
        duration: Time of the last message of the bag in s from its first one.
    """

    def __init__(self, bag: Bag, topics: Container[BagTopic]) -> None:
        self._start_ns = bag.start_ns
        self.duration = (bag.end_ns - bag.start_ns) / 1e9
        self._messages = (one for one in bag.messages() if one[0] in topics)
        self._next: Message | None = next(self._messages, None)

    @property
    def next_s(self) -> float | None:
        """Time of the next message in s; None at the end."""
        return (self._next[1] - self._start_ns) / 1e9 if self._next else None

    def until(self, at: float) -> Iterator[Played]:
        """Yield the next messages up to a time in s."""
        while self._next and (self.next_s or 0.0) <= at:
            topic, _, data = self._next
            self._next = next(self._messages, None)
            yield topic, data


class PlayClock:
    """The time in s since the first message of a recording.

    Attributes:
        paused: Whether the time stops.
    """

    def __init__(self, rate: float, now: float) -> None:
        """Start at a time of the steady clock in s, which this one is `rate` times as fast as."""
        self.paused = False
        self._rate = rate
        self._at = 0.0
        self._since = now

    def at(self, now: float) -> float:
        """Return the time in the recording at a time of the steady clock."""
        return self._at if self.paused else self._at + self._rate * (now - self._since)

    def wait_s(self, at: float, now: float) -> float:
        """Return the time in s until a time in the recording comes, at least 0."""
        return max(0.0, (at - self.at(now)) / self._rate)

    def toggle(self, now: float) -> None:
        """Pause, or resume."""
        self._at, self._since = self.at(now), now
        self.paused = not self.paused
