"""Robots already there, not to be mixed with a recording of them."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from rclpy.node import Node

from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.ros import cmd_vel_topics
from setcmas_simu.ros.fleet_topic import FleetListener


class RobotsThere:
    """Looks whether somebody else has the robots of a recording."""

    def __init__(self, node: Node, names: Collection[str]) -> None:
        """Begin to listen.

        Args:
            node: The node through which the graph is seen.
            names: The topics that are to be played.
        """
        self._node = node
        self._names = sorted(name for name in names if topics.robot_of(name))
        self._robots = sorted({topics.robot_of(name) or 0 for name in names} - {0})
        self._fleet = FleetListener(node)

    def before(self) -> str:
        """Return who has one of the robots while nothing is played yet; empty if nobody."""
        self._fleet.take()
        for source, announced in self._fleet.by_source.items():
            if both := sorted(set(self._robots) & set(announced.robots)):
                return f'{robots_in_words(both, "are")} there already: a {source} has them'
        return self._sender(self._names, 0) or self._listener()

    def beside(self) -> str:
        """Return who has one of the robots beside the player's own publishers; empty if nobody."""
        return self._sender(filter(topics.is_odometry, self._names), 1) or self._listener()

    def _sender(self, names: Iterable[str], own: int) -> str:
        there = (name for name in names if self._node.count_publishers(name) > own)
        return next((f'somebody else publishes {name}' for name in there), '')

    def _listener(self) -> str:
        for robot in self._robots:
            topic = topics.robot_topic(robot, topics.CMD_VEL)
            if found := cmd_vel_topics.listeners(self._node, topic):
                name = topics.robot_name(robot)
                return f'{name} is there already: {found[0].full_name} listens to {topic}'
        return ''
