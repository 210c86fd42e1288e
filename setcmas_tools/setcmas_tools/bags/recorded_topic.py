"""Subscription to one recorded topic, and the times that its messages get in the bag."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from rosbags.interfaces import (
    Connection,
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)

from setcmas_simu.ros.message_class import message_class

DEPTH = 1000
"""Messages of a topic that may wait: a second of the fastest motion capture."""


def stored_qos(profiles: list[QoSProfile]) -> list[Qos]:
    """Return the different profiles of a topic's publishers in the terms of rosbags."""
    stored = [
        Qos(
            QosHistory[profile.history.name],
            profile.depth,
            QosReliability[profile.reliability.name],
            QosDurability[profile.durability.name],
            _time(profile.deadline),
            _time(profile.lifespan),
            QosLiveliness[profile.liveliness.name],
            _time(profile.liveliness_lease_duration),
            profile.avoid_ros_namespace_conventions,
        )
        for profile in profiles
    ]
    return list(dict.fromkeys(stored))


def _time(duration: Duration) -> QosTime:
    return QosTime(*divmod(duration.nanoseconds, 10**9))


_TRANSIENT_LOCAL = DurabilityPolicy.TRANSIENT_LOCAL


@dataclass
class Received:
    """A received message.

    Attributes:
        time_ns: Time of arrival on the system's clock.
    """

    time_ns: int
    topic: RecordedTopic
    data: bytes


class RecordedTopic:
    """Takes the serialised messages of a topic without an executor.

    An executor would wake up for each message and rebuild its wait set over all topics; asking
    each topic for its messages 20 times a second costs a third of that.

    Attributes:
        name: Full name.
        msgtype: Type of its messages.
        connection: The topic in the bag; None until a publisher is known.
    """

    def __init__(self, node: Node, name: str, msgtype: str) -> None:
        """Subscribe, reliably; publishers may not be known yet.

        An early subscription receives the first messages of a later publisher.

        Raises:
            NoPythonTypeError: The type's Python package is missing.
        """
        self.name = name
        self.msgtype = msgtype
        self.connection: Connection | None = None
        self._node = node
        self._class = message_class(msgtype)
        self._has_publishers = False
        self._reliable, self._transient_local = True, False
        self._taken_early: set[int] = set()
        self._subscription: Subscription | None = None
        self._subscribe()

    def adapt_to(self, profiles: list[QoSProfile]) -> list[Received]:
        """Subscribe again if the profiles of publishers require it; return what came before."""
        reliable = all(one.reliability == ReliabilityPolicy.RELIABLE for one in profiles)
        transient_local = all(one.durability == _TRANSIENT_LOCAL for one in profiles)
        if self._has_publishers:
            # Never up again: latched messages would arrive twice.
            reliable &= self._reliable
            transient_local &= self._transient_local
        received = list(self.take())
        self._has_publishers = True
        if self._subscription and (reliable, transient_local) != (
            self._reliable,
            self._transient_local,
        ):
            self._reliable, self._transient_local = reliable, transient_local
            self._node.destroy_subscription(self._subscription)
            self._subscribe()
        return received

    def take(self) -> Iterator[Received]:
        """Yield the messages received since the last call."""
        if self._subscription is None:
            return
        handle = self._subscription.handle
        with handle:
            for _ in range(DEPTH):
                taken = handle.take_message(self._class, True)
                if taken is None:
                    return
                data, info = taken
                if self._is_new(info['source_timestamp']):
                    yield Received(info['received_timestamp'], self, data)

    def close(self) -> None:
        """Unsubscribe; nothing more is received."""
        if self._subscription:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None

    def _subscribe(self) -> None:
        """Subscribe so that as little is lost as the publishers allow."""
        reliability = (
            ReliabilityPolicy.RELIABLE if self._reliable else ReliabilityPolicy.BEST_EFFORT
        )
        durability = _TRANSIENT_LOCAL if self._transient_local else DurabilityPolicy.VOLATILE
        profile = QoSProfile(depth=DEPTH, reliability=reliability, durability=durability)
        self._subscription = self._node.create_subscription(
            self._class, self.name, lambda _: None, profile, raw=True
        )

    def _is_new(self, source_ns: int) -> bool:
        if self._has_publishers:
            # A latched publisher sends its messages again to the second subscription.
            return source_ns not in self._taken_early
        self._taken_early.add(source_ns)
        return True


Timed = tuple[int, Received]
"""A time in ns, and the message that has it."""


class ArrivalTimes:
    """Times of arrival in the time of the robots.

    They start on the system's clock, but do not follow when it is set during a recording:
    a jump of an hour would otherwise freeze or stretch the recorded run.
    """

    def __init__(
        self,
        rtf: float = 1.0,
        system_ns: Callable[[], int] = time.time_ns,
        steady_ns: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        """Start.

        Args:
            rtf: Seconds of the robots per second.
            system_ns: Clock of the messages, in ns; it may be set.
            steady_ns: A clock that is never set, in ns.
        """
        self._rtf = rtf
        self._system_ns = system_ns
        self._steady_ns = steady_ns
        self._begin = self._last = system_ns()
        self._offset = self._begin - steady_ns()

    def of(self, messages: list[Received]) -> Iterator[Timed]:
        """Yield messages with their times, in order, and take them from the list."""
        now = self._system_ns()
        jump = now - self._steady_ns() - self._offset
        messages.sort(key=lambda message: message.time_ns)
        for message in messages:
            arrival = (message.time_ns or now) - jump  # 0 is unknown
            self._last = max(self._last, arrival)
            yield self._begin + round((self._last - self._begin) * self._rtf), message
        messages.clear()
