"""Guard against two simulators of the same robots."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence

from rclpy.node import Node

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.simulator.robot_locks import RobotLocks

_DISCOVERY_S = {'LOCALHOST': 0.4}
_NETWORK_DISCOVERY_S = 1.0
_LOOKS = 50  # robots checked per call
_FORGOTTEN_AFTER_S = 6.0  # one second more than the lease in config/fastdds_network.xml


class SimulatorGuard:
    """Watches the graph for other publishers of these robots' odometry."""

    def __init__(self, node: Node, robots: list[int]) -> None:
        """Lock the robots on this host, and start to look for other simulators elsewhere.

        Args:
            node: Node through which to look at the graph; discovery starts with it.
            robots: Numbers of the robots that this process simulates.

        Raises:
            SetcmasError: Another process on this host simulates one of the robots.
        """
        self._domain = os.environ.get('ROS_DOMAIN_ID', '0')
        self._locks = RobotLocks(robots, self._domain)
        self._node = node
        self._robots = robots
        self._started = time.monotonic()
        self._turn = robots
        self._suspects: set[int] = set()
        self._warned: set[int] = set()

    def others(self, robot: int) -> list[str]:
        """Return the full names of other nodes that publish a robot's odometry."""
        found = self._node.get_publishers_info_by_topic(topics.robot_topic(robot, topics.ODOM))
        names = [f'{info.node_namespace.rstrip("/")}/{info.node_name}' for info in found]
        own = f'/{topics.robot_name(robot)}/{topics.VIRTUAL_ROBOT_NODE}'
        if own in names:
            names.remove(own)
        return names

    def _seen(self, robots: Sequence[int]) -> dict[int, list[str]]:
        return {robot: names for robot in robots if (names := self.others(robot))}

    def refuse_second_simulator(self) -> None:
        """Give other simulators time to appear, then check.

        Raises:
            SetcmasError: Another simulator publishes the odometry of one of the robots.
        """
        discovery_range = os.environ.get('ROS_AUTOMATIC_DISCOVERY_RANGE', 'SUBNET')
        wait = _DISCOVERY_S.get(discovery_range, _NETWORK_DISCOVERY_S)
        time.sleep(max(0.0, self._started + wait - time.monotonic()))
        seen = self._seen(self._robots)
        if seen:
            # A killed process stays on the graph for a while.
            self._node.get_logger().info('others publish odometry; waiting to see if they stay')
            deadline = time.monotonic() + _FORGOTTEN_AFTER_S
            while seen and time.monotonic() < deadline:
                time.sleep(0.1)
                seen = self._seen(self._robots)
        if seen:
            example = next(iter(seen.values()))[0]
            raise SetcmasError(
                f'{robots_in_words(list(seen), "are")} already simulated in ROS domain '
                f'{self._domain} (node {example} publishes odometry): '
                'stop the other simulator, or set another ROS_DOMAIN_ID'
            )

    def warn_of_latecomers(self) -> None:
        """Warn once per robot when another publisher of its odometry has appeared and stayed.

        Each call checks some robots, and the next call continues with the next ones.
        """
        some, self._turn = self._turn[:_LOOKS], self._turn[_LOOKS:] or self._robots
        seen = self._seen(some)
        # A second simulator is visible briefly before it refuses to start.
        staying = self._suspects & set(seen)
        self._suspects = (self._suspects - set(some)) | set(seen)
        for robot, names in seen.items():
            if robot in staying - self._warned:
                self._warned.add(robot)
                self._node.get_logger().warning(
                    f'{names[0]} also publishes the odometry of {topics.robot_name(robot)}: '
                    'two simulators move it; stop one of them'
                )
