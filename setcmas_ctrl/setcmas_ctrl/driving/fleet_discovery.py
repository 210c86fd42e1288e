"""Discovery of a fleet: waits for its announcement and odometry, and reports lost robots."""

from __future__ import annotations

import time
from collections.abc import Callable, Container, Sequence

from rclpy.node import Node

from setcmas_ctrl.driving.odometry import FleetOdometry
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.announcement import Kind, own_source
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.ros.fleet_topic import FleetListener
from setcmas_simu.ros.process import FleetNode, RosProcess

_ODOMETRY_TYPE = 'nav_msgs/msg/Odometry'
_SETTLED_S = 1.5
_REMIND_EVERY_S = 2.0


def robots_with_odometry(
    node: Node,
    topic_of: Callable[[int], str] = topics.odometry_topic,
    known: Container[int] = (),
) -> list[int]:
    """Return the sorted numbers of robots with odometry publishers, except known ones."""
    robots = [
        robot
        for name, types in node.get_topic_names_and_types()
        if _ODOMETRY_TYPE in types
        and (robot := topics.robot_of(name))
        and robot not in known
        and name == topic_of(robot)
        and node.count_publishers(name)
    ]
    return sorted(robots)


def wait_until(
    process: RosProcess, is_there: Callable[[], bool], remind: Callable[[], object]
) -> bool:
    """Wait for something, and remind the user every 2 s.

    Returns:
        Whether it is there; False if the process must stop.
    """
    while not process.stopping and not process.spin_until(is_there, _REMIND_EVERY_S):
        if not process.stopping:
            remind()
    return not process.stopping


def wait_for_fleet(process: RosProcess, node: FleetNode, listener: FleetListener) -> int:
    """Wait until all processes with robots have announced them.

    If something announces them in a way that is not understood, their odometry counts.

    Returns:
        Size of the fleet; 0 if the process must stop.
    """
    changed, seen = time.monotonic(), (0, [0])

    def is_known() -> bool:
        nonlocal changed, seen
        nb_announcements = len(listener.take())
        is_unread = listener.unread and listener.is_useless
        robots = robots_with_odometry(node) if is_unread else []
        if (nb_announcements, robots) != seen:
            changed, seen = time.monotonic(), (nb_announcements, robots)
        # A killed process stays in the graph for a while and will not announce anything.
        is_settled = time.monotonic() - changed >= _SETTLED_S
        if nb_announcements:
            return listener.announced_by_all or is_settled
        return bool(robots) and is_settled

    text = (
        f'waiting for a fleet: no announcement on {node.full_name(topics.FLEET)}; is setcmas simu '
        'running in the same ROS domain and namespace? For another simulator, add --nb-robots'
    )
    warn = node.get_logger().warning

    def remind() -> None:
        found = robots_with_odometry(node)
        there = f'; {robots_in_words(found, "publish")} odometry' if found else ''
        warn(f'{text}{there}')

    if not wait_until(process, is_known, remind):
        return 0
    if not listener.nb_robots:
        warn(f'using the robots that publish odometry: {robots_in_words(seen[1])}')
    return listener.nb_robots or max(seen[1])


def wait_for_source(process: RosProcess, node: Node, listener: FleetListener, pid: int) -> bool:
    """Wait for the simulator or lab with a process ID on this machine.

    Returns:
        Whether it has announced its robots; False if this process must stop.
    """
    source = own_source(Kind.SIMULATOR, pid)
    text = f'waiting for the {source} to announce its robots'
    warn = node.get_logger().warning
    return wait_until(process, lambda: source in listener.take(), lambda: warn(text))


def wait_for_announcement(
    process: RosProcess, node: Node, listener: FleetListener, nb_robots: int
) -> bool:
    """Wait until the robots' simulated time is known, if there is an announcer.

    Returns:
        Whether it is known; False if this process must stop.
    """

    def is_known() -> bool:
        # Whoever has discovered the odometry of a simulator has also discovered its announcer.
        announced = bool(listener.take())
        return announced or (listener.is_useless and bool(robots_with_odometry(node)))

    text = (
        f'waiting for the odometry of {robots_in_words([*range(1, nb_robots + 1)])} '
        f'({topics.odometry_topic(1)}); is their simulator running?'
    )
    warn = node.get_logger().warning
    return wait_until(process, is_known, lambda: warn(text))


class LostRobots:
    """Reports robots whose odometry becomes too old, and when it returns."""

    def __init__(
        self, robots: Sequence[int], odometry: FleetOdometry, warn: Callable[[str], None]
    ) -> None:
        self._robots = robots
        self._odometry = odometry
        self._warn = warn
        self._lost: set[int] = set()

    def __contains__(self, robot: int) -> bool:
        return robot in self._lost

    def update(self, timeout_s: float) -> None:
        """Find robots whose odometry is older than a time in s."""
        for robot in self._robots:
            age = self._odometry.age(robot)
            if age > timeout_s and robot not in self._lost:
                self._lost.add(robot)
                fault = self._odometry.fault(robot)
                missing = f'no valid odometry ({fault})' if fault else 'no odometry'
                self._warn(f'robot {robot}: {missing} for {age:.1f} s; it gets zero velocity')
            elif age <= timeout_s and robot in self._lost:
                self._lost.remove(robot)
                self._warn(f'robot {robot}: odometry is back')
