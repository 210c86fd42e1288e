"""Latched topic /fleet, on which simulators and labs announce their robots."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from rclpy.node import Node
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


class FleetListener:
    """Keeps the newest announcement of each process; calls `on_change` after each one."""

    def __init__(self, node: Node) -> None:
        """Subscribe through a node; `take` takes new announcements."""
        self._node = node
        self.by_source: dict[Source, Announcement] = {}
        self._was_there = False
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
        """Whether all publishers of the topic have announced their robots; true if none exists."""
        announcers: int = self._node.count_publishers(topics.FLEET)
        return announcers <= len(self.by_source)

    def take(self) -> Mapping[Source, Announcement]:
        """Take new announcements and return all; forget those of processes that are gone."""
        self._topic.take()
        is_there = self._node.count_publishers(topics.FLEET) > 0
        if self._was_there and not is_there:
            self.by_source.clear()
        self._was_there = is_there
        return self.by_source

    def _on_text(self, message: String) -> None:
        if announcement := decode(message.data):
            self.by_source[announcement.source] = announcement
            self.on_change()
