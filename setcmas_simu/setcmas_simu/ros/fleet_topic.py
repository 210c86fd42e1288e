"""Latched topic /fleet, on which each process announces its robots by a line of JSON."""

from __future__ import annotations

from typing import Annotated

import msgspec
from msgspec import Meta
from rclpy.node import Node
from std_msgs.msg import String

from setcmas_simu.fleet import topics
from setcmas_simu.fleet.topics import MAX_ROBOTS
from setcmas_simu.ros import qos
from setcmas_simu.ros.polling import PolledTopic

_Robot = Annotated[int, Meta(ge=1, le=MAX_ROBOTS)]


class Announcement(msgspec.Struct, frozen=True, omit_defaults=True):
    """The robots of one process, all of a fleet or a part.

    Their simulated time goes by at `rtf` s per real second.
    """

    nb_robots: Annotated[_Robot, Meta(description='size of the whole fleet')]
    robots: Annotated[tuple[_Robot, ...], Meta(description='sorted numbers')]
    models: Annotated[
        tuple[str, ...], Meta(description='name or script for each robot; empty for unicycles')
    ] = ()
    limits: Annotated[str, Meta(description='velocity limits of unicycles')] = 'ideal'
    rtf: Annotated[float, Meta(gt=0, description='real-time factor')] = 1.0
    begin: Annotated[
        float, Meta(description='time 0 in s of the system clock, if rtf is not 1')
    ] = 0.0


class FleetAnnouncer:
    """Announces the robots of this process, to present and future subscribers.

    Create it before the robots' nodes, so that whoever discovers their topics has found this one.
    """

    def __init__(self, node: Node) -> None:
        self._publisher = node.create_publisher(String, topics.FLEET, qos.LATCHED)

    def announce(self, announcement: Announcement) -> None:
        """Publish an announcement in place of the one before."""
        self._publisher.publish(String(data=msgspec.json.encode(announcement).decode()))


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
            new = msgspec.json.decode(message.data, type=Announcement)
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
