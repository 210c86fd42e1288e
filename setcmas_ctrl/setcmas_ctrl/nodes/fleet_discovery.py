"""Finds the fleet by the odometry topics on the ROS graph."""

from __future__ import annotations

import time
from collections.abc import Callable

from rclpy.node import Node

from setcmas_simu import topics
from setcmas_simu.nodes.ros_process import RosProcess

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
    """Return the size of the fleet once its robots have been seen and no more appear.

    Returns:
        The largest robot number; 0 if the process was asked to stop meanwhile.
    """
    found: list[int] = []
    since = reminded = time.monotonic()

    def settled() -> bool:
        nonlocal found, since, reminded
        now = time.monotonic()
        robots = robots_with_odometry(node)
        if robots != found:
            found, since = robots, now
        if not found and now - reminded > _REMIND_EVERY_S:
            reminded = now
            node.get_logger().warning(
                f'waiting for a fleet: nothing publishes {topics.robot_topic(1, topics.ODOM)} '
                'yet; is setcmas simu running, in the same ROS domain?'
            )
        return bool(found) and now - since >= _SETTLED_S

    while not process.stopping and not process.spin_until(settled, timeout_s=1.0):
        pass
    return found[-1] if found and not process.stopping else 0
