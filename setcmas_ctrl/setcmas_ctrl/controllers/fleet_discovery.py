"""Discovery of a fleet: waits for its announcement and odometry, and reports lost robots."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from rclpy.node import Node

from setcmas_ctrl.fleet_poses import FleetPoses
from setcmas_ctrl.laws.script_errors import StopCall
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.ros.clocks import ScaledClock, SteadyClock, TopicClock
from setcmas_simu.ros.fleet_node import SIMULATED_TIME, FleetNode
from setcmas_simu.ros.fleet_topic import FleetListener
from setcmas_simu.ros.process import RosProcess

_ODOMETRY_TYPE = 'nav_msgs/msg/Odometry'
_SETTLED_S = 1.5
_FORGOTTEN_AFTER_S = 6.0  # one second more than the lease in config/fastdds_network.xml
_REMIND_EVERY_S = 2.0


def _robots_with_odometry(node: Node) -> list[int]:
    """Return the sorted numbers of robots with odometry publishers."""
    robots = [
        robot
        for name, types in node.get_topic_names_and_types()
        if _ODOMETRY_TYPE in types
        and (robot := topics.robot_of(name))
        and name == topics.odometry_topic(robot)
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


def wait_for_fleet(
    process: RosProcess, node: FleetNode, listener: FleetListener, nb_robots: int | None = None
) -> int:
    """Wait until the robots of a fleet are announced, or publish odometry if none is announced.

    Returns:
        Size of the fleet, nb_robots if given.

    Raises:
        StopCall: The process was asked to stop meanwhile.
    """
    changed, seen = time.monotonic(), (0, [0])

    def is_known() -> bool:
        nonlocal changed, seen
        listener.take()
        robots = [] if listener.robots else _robots_with_odometry(node)
        if (len(listener.robots), robots) != seen:
            changed, seen = time.monotonic(), (len(listener.robots), robots)
        settled_s = time.monotonic() - changed
        # A killed process stays in the graph for a while and will not announce anything.
        if listener.robots:
            return listener.is_complete or settled_s >= _SETTLED_S
        if node.count_publishers(topics.FLEET):
            return bool(robots) and settled_s >= _FORGOTTEN_AFTER_S
        return bool(robots) and (len(robots) == nb_robots or settled_s >= _SETTLED_S)

    warn = node.get_logger().warning
    go_on(wait_until(process, is_known, lambda: warn(_missing(node, nb_robots))))
    if not listener.robots:
        warn(
            f'nothing announces a fleet on {node.full_name(topics.FLEET)}: '
            f'{robots_in_words(seen[1], "are")} found by odometry, and treated as unicycles '
            'unless --model says otherwise'
        )
    return nb_robots or listener.nb_robots or max(seen[1])


def _missing(node: FleetNode, nb_robots: int | None) -> str:
    """Return what a controller waits for, and how to get it."""
    if nb_robots:
        robots = robots_in_words([*range(1, nb_robots + 1)])
        return (
            f'waiting for the odometry of {robots} ({topics.odometry_topic(1)}); is their '
            'simulator running?'
        )
    return (
        f'waiting for a fleet: nothing is announced on {node.full_name(topics.FLEET)}; is setcmas '
        'simu running in the same ROS domain and namespace?'
    )


def clock_of_robots(process: RosProcess, node: FleetNode, announced: FleetListener) -> SteadyClock:
    """Return the clock of the robots; wait for one on /clock.

    Raises:
        StopCall: The process was asked to stop meanwhile.
    """
    if announced.rtf != 1.0:
        return ScaledClock(announced.rtf, announced.begin)
    if not node.get_parameter(SIMULATED_TIME).value:
        return SteadyClock()
    clock = TopicClock(node)
    text = f'waiting for the time on {topics.CLOCK} ({SIMULATED_TIME}); is it published?'
    go_on(wait_until(process, clock.has_begun, lambda: node.get_logger().warning(text)))
    return clock


class LostRobots:
    """Reports robots whose odometry becomes too old, and when it returns."""

    def __init__(
        self, robots: Sequence[int], poses: FleetPoses, warn: Callable[[str], None]
    ) -> None:
        self._robots = robots
        self._poses = poses
        self._warn = warn
        self._lost: set[int] = set()

    def __contains__(self, robot: int) -> bool:
        return robot in self._lost

    def update(self, timeout_s: float) -> None:
        """Find robots whose odometry is older than a time in s."""
        for robot in self._robots:
            age = self._poses.age(robot)
            if age > timeout_s and robot not in self._lost:
                self._lost.add(robot)
                fault = self._poses.fault(robot)
                missing = f'no valid pose ({fault})' if fault else 'no pose'
                topic = self._poses.topic_of(robot)
                self._warn(
                    f'robot {robot}: {missing} for {age:.1f} s on {topic}; it gets zero velocity'
                )
            elif age <= timeout_s and robot in self._lost:
                self._lost.remove(robot)
                self._warn(f'robot {robot}: its poses are back')


def go_on(found: object) -> None:
    """End the process if nothing was found: then it was asked to stop.

    Raises:
        StopCall: Nothing was found.
    """
    if not found:
        raise StopCall
