"""Latched topic /fleet, on which simulators and labs announce their robots."""

from __future__ import annotations

from rclpy.node import Node
from std_msgs.msg import String

from setcmas_simu.fleet import topics
from setcmas_simu.fleet.announcement import Announcement, decode, encode
from setcmas_simu.ros import qos
from setcmas_simu.ros.polling import PolledTopic


class FleetAnnouncer:
    """Announces the robots of this process, to present and future subscribers.

    Create it before the robots' nodes, so that whoever discovers their topics has found this one.
    """

    def __init__(self, node: Node) -> None:
        self._publisher = node.create_publisher(String, topics.FLEET, qos.LATCHED)

    def announce(self, announcement: Announcement) -> None:
        """Publish an announcement in place of the one before."""
        self._publisher.publish(String(data=encode(announcement)))


class FleetListener:
    """Keeps the announcements of a fleet's processes.

    Attributes:
        announcements: The newest ones, in which each robot is once.
    """

    def __init__(self, node: Node) -> None:
        """Subscribe through a node; `take` takes new announcements."""
        self._node = node
        self.announcements: list[Announcement] = []
        self._has_warned = False
        self._topic = PolledTopic(node, String, topics.FLEET, self._on_line, qos.LATCHED_BY_MANY)

    @property
    def robots(self) -> list[int]:
        """Announced robots, sorted."""
        return sorted(robot for one in self.announcements for robot in one.robots)

    @property
    def nb_robots(self) -> int:
        """Size of the announced fleet; 0 if there is none."""
        return max((one.nb_robots for one in self.announcements), default=0)

    @property
    def models(self) -> dict[int, str]:
        """Announced models by robot."""
        return {
            robot: model
            for one in self.announcements
            for robot, model in zip(one.robots, one.models, strict=False)
        }

    @property
    def first(self) -> Announcement:
        """The first announcement: all have the same limits and time. Defaults if none has come."""
        return self.announcements[0] if self.announcements else Announcement(0, ())

    @property
    def is_complete(self) -> bool:
        """Whether all publishers of the topic have announced their robots."""
        nb_publishers: int = self._node.count_publishers(topics.FLEET)
        return 0 < nb_publishers <= len(self.announcements)

    def take(self) -> None:
        """Take new announcements; forget all once no publisher is left."""
        self._topic.take()
        if self.announcements and not self._node.count_publishers(topics.FLEET):
            self.announcements.clear()

    def _on_line(self, message: String) -> None:
        try:
            new = decode(message.data)
        except ValueError as error:
            if not self._has_warned:
                self._has_warned = True
                topic = self._topic.subscription.topic_name
                self._node.get_logger().warning(
                    f'{topic}: a message is ignored, because it is no announcement of robots as '
                    f'docs/schemas/fleet-1.json describes it ({error})'
                )
            return
        # A simulator that starts again, maybe with other robots, replaces the one before.
        others = [one for one in self.announcements if not {*one.robots} & {*new.robots}]
        self.announcements = [*others, new]
