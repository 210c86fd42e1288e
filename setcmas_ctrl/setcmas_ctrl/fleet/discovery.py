"""Finds the fleet by the odometry topics on the ROS graph."""

from __future__ import annotations

import time
from collections.abc import Callable

from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.subscription import Subscription

from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import format_robots
from setcmas_simu.ros import qos
from setcmas_simu.ros.process import RosProcess

_ODOMETRY_TYPE = 'nav_msgs/msg/Odometry'
_SETTLED_S = 0.2
_REMIND_EVERY_S = 2.0


def robots_with_odometry(
    node: Node, topic_of: Callable[[int], str] = topics.odometry_topic
) -> list[int]:
    """Return the numbers of the robots whose odometry somebody publishes, sorted.

    Args:
        node: The node through which the graph is seen.
        topic_of: Gives the topic of each robot's odometry.
    """
    robots = [
        robot
        for name, types in node.get_topic_names_and_types()
        if _ODOMETRY_TYPE in types
        and (robot := topics.robot_of(name))
        and name == topic_of(robot)
        and node.count_publishers(name)
    ]
    return sorted(robots)


def wait_for_fleet(process: RosProcess, node: Node) -> int:
    """Return the size of the fleet once all robots on the graph are heard and no more appear.

    Returns:
        The largest robot number; 0 if the process was asked to stop meanwhile.
    """
    fleet = _Fleet(node)
    while not process.stopping and not process.spin_until(fleet.is_complete, _REMIND_EVERY_S):
        if not process.stopping:
            fleet.remind()
    fleet.close()
    return 0 if process.stopping else max(fleet.robots)


class _Fleet:
    """The robots found so far, and which of them have been heard since the last one appeared.

    A simulator that is still creating its robots is on the graph with some of them, on a busy
    machine for long; it sends odometry once it has them all.
    """

    def __init__(self, node: Node) -> None:
        self.robots: set[int] = set()
        self._node = node
        self._heard: set[int] = set()
        self._since = 0.0
        self._subscriptions: dict[int, Subscription] = {}

    def is_complete(self) -> bool:
        """Look at the graph; return whether all robots are heard and no more appear."""
        robots = set(robots_with_odometry(self._node))
        if robots != self.robots:
            self.robots, self._since = robots, time.monotonic()
            self._heard.clear()
            for robot in robots - set(self._subscriptions):
                self._listen(robot)
        settled = time.monotonic() - self._since >= _SETTLED_S
        return bool(robots) and settled and robots <= self._heard

    def remind(self) -> None:
        """Say what is missing."""
        if silent := sorted(self.robots - self._heard):
            message = (
                f'robots {format_robots(sorted(self.robots))} are there, but '
                f'{topics.odometry_topic(silent[0])} is silent; is their simulator held up?'
            )
        else:
            message = (
                f'waiting for a fleet: nothing publishes {topics.odometry_topic(1)} yet; '
                'is setcmas simu running, in the same ROS domain?'
            )
        self._node.get_logger().warning(message)

    def close(self) -> None:
        """Listen no more."""
        for subscription in self._subscriptions.values():
            self._node.destroy_subscription(subscription)

    def _listen(self, robot: int) -> None:
        self._subscriptions[robot] = self._node.create_subscription(
            Odometry,
            topics.odometry_topic(robot),
            lambda _: self._heard.add(robot),
            qos.STATE,
        )
