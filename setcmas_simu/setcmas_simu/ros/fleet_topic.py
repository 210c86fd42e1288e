"""Latched topic /fleet, on which simulators and labs announce their robots."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy
from std_msgs.msg import String

from setcmas_simu.fleet import topics
from setcmas_simu.fleet.announcement import (
    Announcement,
    Kind,
    SimulatedTime,
    Source,
    decode,
    encode,
    own_source,
)
from setcmas_simu.ros import qos
from setcmas_simu.ros.polling import PolledTopic


class FleetAnnouncer:
    """Announces the robots of this process.

    Create it before the robots' nodes, so that whoever discovers their topics has found this one.
    """

    def __init__(self, node: Node, kind: Kind) -> None:
        self._source = own_source(kind)
        self._publisher = node.create_publisher(String, topics.FLEET, qos.LATCHED)

    def announce(
        self,
        robots: Sequence[int],
        nb_robots: int,
        models: Sequence[str] = (),
        time: SimulatedTime | None = None,
    ) -> None:
        """Announce robots (sorted numbers) of a fleet, to present and future subscribers.

        Without models all are unicycles; without a simulated time they use the system clock.
        """
        announcement = Announcement(nb_robots, tuple(robots), self._source, tuple(models), time)
        self._publisher.publish(String(data=encode(announcement)))


_TYPE = 'std_msgs/msg/String'
_MOST_UNREAD = 16  # texts and reasons


class FleetListener:
    """Keeps the newest announcement of each process; calls `on_change` after each one.

    `unread` has the reasons why messages or publishers are ignored; each gives a warning.
    """

    def __init__(self, node: Node) -> None:
        """Subscribe through a node; `take` takes new announcements."""
        self._node = node
        self.by_source: dict[Source, Announcement] = {}
        self.unread: list[str] = []
        self._unread_texts: set[str] = set()
        self._nb_publishers = self._nb_announcers = 0
        self.on_change: Callable[[], None] = lambda: None
        self._topic = PolledTopic(node, String, topics.FLEET, self._on_text, qos.LATCHED_BY_MANY)

    @property
    def robots(self) -> list[int]:
        """Announced robots, sorted."""
        return sorted({robot for one in self.by_source.values() for robot in one.robots})

    @property
    def nb_robots(self) -> int:
        """Size of the announced fleet; 0 if there is none."""
        return max((one.nb_robots for one in self.by_source.values()), default=0)

    @property
    def models(self) -> dict[int, str]:
        """Announced models by robot."""
        return {
            robot: model
            for one in self.by_source.values()
            for robot, model in zip(one.robots, one.models, strict=False)
        }

    @property
    def time(self) -> SimulatedTime | None:
        """Simulated time of the robots; None is the system clock."""
        return next((one.time for one in self.by_source.values() if one.time), None)

    @property
    def announced_by_all(self) -> bool:
        """Whether all publishers have announced their robots or sent what is not understood."""
        return self._nb_announcers <= len(self.by_source) + len(self._unread_texts)

    @property
    def is_useless(self) -> bool:
        """Whether nothing announces robots, or only in a way that is not understood."""
        return not self.by_source and self.announced_by_all

    def take(self) -> Mapping[Source, Announcement]:
        """Take new announcements and return all; forget those of processes that are gone."""
        self._topic.take()
        nb_publishers: int = self._node.count_publishers(topics.FLEET)
        if nb_publishers != self._nb_publishers:
            self._look_at_publishers()
            if nb_publishers == 0:
                self.by_source.clear()
                self._unread_texts.clear()
            self._nb_publishers = nb_publishers
        return self.by_source

    def _look_at_publishers(self) -> None:
        """Count the publishers that can announce robots, and report the others."""
        self._nb_announcers = 0
        for info in self._node.get_publishers_info_by_topic(topics.FLEET):
            latched = info.qos_profile.durability != DurabilityPolicy.VOLATILE
            if info.topic_type == _TYPE and latched:
                self._nb_announcers += 1
            else:
                how = 'latched' if latched else 'volatile'
                self._ignore(f'a {how} publisher of {info.topic_type}')

    def _on_text(self, message: String) -> None:
        try:
            announcement = decode(message.data)
        except ValueError as error:
            self._ignore(str(error))
            if len(self._unread_texts) < _MOST_UNREAD:
                self._unread_texts.add(message.data)
        else:
            self.by_source[announcement.source] = announcement
            self.on_change()

    def _ignore(self, reason: str) -> None:
        if reason not in self.unread and len(self.unread) < _MOST_UNREAD:
            self.unread.append(reason)
            topic = self._topic.subscription.topic_name
            self._node.get_logger().warning(
                f'ignored on {topic}: {reason}; announcements are latched {_TYPE}, '
                'described in docs/schemas/fleet-1.json'
            )
