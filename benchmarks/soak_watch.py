"""What a soak watches: messages of the fleet as they arrive, and what its processes hold."""

from __future__ import annotations

import time
from dataclasses import dataclass, field

import psutil
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from sensor_msgs.msg import TimeReference

from setcmas_simu.fleet import topics

DEPTH = 200


@dataclass
class Stream:
    """Messages of one topic: how many, when, and how long they were on their way."""

    period: float
    until: float = float('inf')  # what is sent later does not count
    count: int = 0
    first: float = 0.0
    last: float = 0.0
    arrived: float = -float('inf')
    ages: list[float] = field(default_factory=list)

    def add(self, sent: float, age: float = 0.0) -> None:
        """Take a message that was sent at a time (s), and took `age` s."""
        if sent <= self.until:
            self.first = self.first if self.count else sent
            self.last = sent
            self.count += 1
        self.arrived = time.monotonic()
        self.ages.append(age)

    @property
    def missing(self) -> int:
        """How many more messages there would be at the nominal rate."""
        return round((self.last - self.first) / self.period) + 1 - self.count if self.count else 0

    @property
    def silence(self) -> float:
        """Time in s since the last message."""
        return time.monotonic() - self.arrived


class Observer:
    """Takes odometry and commands of a fleet, and t of its controllers, without an executor."""

    def __init__(self, node: Node, nb_robots: int) -> None:
        robots = range(1, nb_robots + 1)
        self.odometry = {robot: Stream(0.1) for robot in robots}
        self.commands = {robot: Stream(0.2) for robot in robots}
        self.t: dict[str, tuple[float, float]] = {}
        self._subscriptions = []
        for kind, topic, streams in (
            (Odometry, topics.ODOM, self.odometry),
            (TwistStamped, topics.CMD_VEL, self.commands),
        ):
            for robot, stream in streams.items():
                name = topics.robot_topic(robot, topic)
                subscription = node.create_subscription(kind, name, lambda _: None, DEPTH)
                self._subscriptions.append((subscription, stream))
        self._time = node.create_subscription(
            TimeReference, topics.FLEET_TIME, lambda _: None, DEPTH
        )

    def take(self) -> None:
        """Take what has come."""
        for subscription, stream in self._subscriptions:
            for _, info in _messages(subscription):
                sent, received = info['source_timestamp'], info['received_timestamp']
                stream.add(1e-9 * sent, 1e-9 * (received - sent))
        for message, info in _messages(self._time):
            t = message.time_ref.sec + 1e-9 * message.time_ref.nanosec
            part = message.source.partition(' (')[0]
            self.t[part] = (time.monotonic(), 1e-9 * info['source_timestamp'] - t)

    def spread_of_t(self) -> float:
        """Return how far t of the controllers that are heard lie apart, in s."""
        now = time.monotonic()
        zeros = [zero for at, zero in self.t.values() if now - at < 1.0]
        return max(zeros) - min(zeros) if zeros else 0.0

    def ages(self) -> list[float]:
        """Return the ages (s) of all messages since the last call."""
        every = []
        for _, stream in self._subscriptions:
            every += stream.ages
            stream.ages.clear()
        return every


def _messages(subscription):
    with subscription.handle:
        while (
            taken := subscription.handle.take_message(subscription.msg_type, False)
        ) is not None:
            yield taken


@dataclass(frozen=True)
class Holding:
    """What a process holds at a time (s since the begin)."""

    at: float
    memory: float  # MB of its own: what is shared depends on who else is there
    threads: int
    descriptors: int
    sockets: int


def holding(pid: int, at: float) -> Holding:
    """Return what a process holds now."""
    process = psutil.Process(pid)
    with process.oneshot():
        return Holding(
            at,
            process.memory_full_info().uss / 1e6,
            process.num_threads(),
            process.num_fds(),
            len(process.net_connections('udp')),
        )
