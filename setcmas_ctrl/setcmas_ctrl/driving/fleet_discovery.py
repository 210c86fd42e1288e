"""Discovery of the robots of a fleet by their odometry, and their loss."""

from __future__ import annotations

import time
from collections.abc import Callable, Container, Sequence

from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.subscription import Subscription

from setcmas_ctrl.driving.odometry import FleetOdometry
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import Kind, own_source, robots_in_words
from setcmas_simu.ros import qos
from setcmas_simu.ros.fleet_topic import FleetListener
from setcmas_simu.ros.process import RosProcess

_ODOMETRY_TYPE = 'nav_msgs/msg/Odometry'
_SETTLED_S = 1.5
_REMIND_EVERY_S = 2.0


def robots_with_odometry(
    node: Node,
    topic_of: Callable[[int], str] = topics.odometry_topic,
    known: Container[int] = (),
) -> list[int]:
    """Return the numbers of the robots whose odometry somebody publishes, sorted.

    Args:
        node: The node through which the graph is seen.
        topic_of: Gives the topic of each robot's odometry.
        known: Robots that are left out.
    """
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


def wait_for_fleet(process: RosProcess, node: Node, listener: FleetListener) -> int:
    """Return the size of the fleet that is announced; where nobody announces, guess and say so.

    Args:
        process: Serves the subscriptions meanwhile.
        node: The node through which the graph is seen.
        listener: Takes announcements.

    Returns:
        Size of the fleet; 0 if the process was asked to stop meanwhile.
    """
    fleet = _Fleet(node, listener)
    while not process.stopping and not process.spin_until(fleet.is_known, _REMIND_EVERY_S):
        if not process.stopping:
            fleet.remind()
    fleet.close()
    return 0 if process.stopping else fleet.nb_robots


def wait_for_source(process: RosProcess, node: Node, listener: FleetListener, pid: int) -> bool:
    """Wait until a process of this machine has announced its robots.

    Returns:
        Whether it has; False if this process was asked to stop meanwhile.
    """
    source = own_source(Kind.SIMULATOR, pid)
    while not process.stopping and not process.spin_until(
        lambda: source in listener.take(), _REMIND_EVERY_S
    ):
        if not process.stopping:
            node.get_logger().warning(f'waiting for the {source} to announce its robots')
    return not process.stopping


def wait_for_announcement(
    process: RosProcess, node: Node, listener: FleetListener, nb_robots: int
) -> bool:
    """Wait until the time that robots follow is known: it is announced, if anybody announces any.

    Returns:
        Whether it is known; False if this process was asked to stop meanwhile.
    """

    def is_known() -> bool:
        # Who has discovered the odometry of a simulator knows of its announcer.
        nobody = node.count_publishers(topics.FLEET) == 0
        return bool(listener.take()) or (nobody and bool(robots_with_odometry(node)))

    while not process.spin_until(is_known, _REMIND_EVERY_S) and not process.stopping:
        node.get_logger().warning(
            f'waiting for the odometry of {robots_in_words([*range(1, nb_robots + 1)])} '
            f'({topics.odometry_topic(1)}); is their simulator running?'
        )
    return not process.stopping


class _Fleet:
    """What is announced; and the robots in sight, for the case that nobody announces any."""

    def __init__(self, node: Node, listener: FleetListener) -> None:
        self.nb_robots = 0
        self._node = node
        self._announced = listener
        self._robots: set[int] = set()
        self._heard: set[int] = set()
        self._changed = time.monotonic()
        self._nb_announcements = 0
        self._subscriptions: dict[int, Subscription] = {}

    def is_known(self) -> bool:
        """Look at what is announced, and at the graph; return whether the fleet is known."""
        if self._announced.take():
            self._note_change(len(self._announced.by_source) != self._nb_announcements)
            self._nb_announcements = len(self._announced.by_source)
            # Who was killed stays on the graph for a while, and will not announce anything.
            if self._announced.announced_by_all or self._settled():
                self.nb_robots = self._announced.nb_robots
        elif self._announced.announced_by_all:  # that is, nobody is there who would
            self._guess()
        return self.nb_robots > 0

    def remind(self) -> None:
        """Say what is missing."""
        if silent := sorted(self._robots - self._heard):
            message = (
                f'{robots_in_words(sorted(self._robots), "are")} there, but '
                f'{topics.odometry_topic(silent[0])} is silent; is their simulator held up?'
            )
        else:
            message = (
                f'waiting for a fleet: nobody announces one on {topics.FLEET}, and nothing '
                f'publishes {topics.odometry_topic(1)} yet; '
                'is setcmas simu running, in the same ROS domain?'
            )
        self._node.get_logger().warning(message)

    def close(self) -> None:
        """Listen no more to robots."""
        for subscription in self._subscriptions.values():
            self._node.destroy_subscription(subscription)

    def _guess(self) -> None:
        robots = set(robots_with_odometry(self._node))
        self._note_change(robots != self._robots)
        self._robots = robots
        for robot in robots - set(self._subscriptions):
            self._listen(robot)
        if robots and robots <= self._heard and self._settled():
            self.nb_robots = max(robots)
            self._node.get_logger().warning(
                f'nobody announces a fleet on {topics.FLEET}: '
                f'{robots_in_words(sorted(robots), "are")} taken for all of it, because odometry '
                'is heard; --nb-robots says how many there are'
            )

    def _note_change(self, changed: bool) -> None:
        if changed:
            self._changed = time.monotonic()

    def _settled(self) -> bool:
        return time.monotonic() - self._changed >= _SETTLED_S

    def _listen(self, robot: int) -> None:
        self._subscriptions[robot] = self._node.create_subscription(
            Odometry,
            topics.odometry_topic(robot),
            lambda _: self._heard.add(robot),
            qos.STATE,
        )


class LostRobots:
    """Says whose odometry is too old; tells it, and when it is back."""

    def __init__(
        self, robots: Sequence[int], odometry: FleetOdometry, warn: Callable[[str], None]
    ) -> None:
        """Begin with none lost; `warn` shows a message to the user."""
        self._robots = robots
        self._odometry = odometry
        self._warn = warn
        self._lost: set[int] = set()

    def __contains__(self, robot: int) -> bool:
        """Return whether a robot is lost."""
        return robot in self._lost

    def look(self, timeout_s: float) -> None:
        """Look whose odometry is older than a time in s."""
        for robot in self._robots:
            age = self._odometry.age(robot)
            if age > timeout_s and robot not in self._lost:
                self._lost.add(robot)
                self._warn(f'robot {robot}: no odometry for {age:.1f} s; it is commanded zero')
            elif age <= timeout_s and robot in self._lost:
                self._lost.remove(robot)
                self._warn(f'robot {robot}: odometry is back')
