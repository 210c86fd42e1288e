"""Monitor of the ROS graph: robots that do not listen, and other controllers."""

from __future__ import annotations

import enum
import time
from collections.abc import Callable, Sequence

from rclpy.node import Node

from setcmas_ctrl.fleet_poses import FleetPoses
from setcmas_ctrl.si_to_uni_node import SiToUni
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.fleet.topics import RECORDER_NODE, RECORDER_NODES
from setcmas_simu.ros import cmd_vel_topics

_ROUND_EVERY_S = 2.0
_NOW_S, _SOON_S = 0.0, 1.9  # in the next round
_FORGOTTEN_AFTER_S = 6.0  # one second more than the lease in config/fastdds_network.xml


class Problem(enum.Enum):
    """What the graph shows of a robot, and how long it must last before it is reported, in s."""

    MIXED = 'its cmd_vel has listeners of several types', _NOW_S
    UNHEARD = 'nothing listens to its cmd_vel', _SOON_S
    # A killed process stays in the graph for a while.
    RIVAL = 'another node commands it', _FORGOTTEN_AFTER_S
    SEVERAL = 'several nodes publish its velocity', _FORGOTTEN_AFTER_S


class GraphWatch:
    """Checks the graph now and then, and reports each problem of a robot once."""

    def __init__(self, node: Node, poses: FleetPoses, drivers: Sequence[SiToUni]) -> None:
        """Begin to watch the robots that `drivers` command."""
        self._node = node
        self._poses = poses
        self._drivers = drivers
        self._next_round = 0.0
        self._unchecked: list[SiToUni] = []
        self._found: dict[tuple[Problem, int], str] = {}  # in this round, and what it is about
        self._since: dict[tuple[Problem, int], float] = {}
        self._reported: set[tuple[Problem, int]] = set()

    def all_connected(self) -> Callable[[], bool]:
        """Return a check whether all robots listen, which also adapts the type of cmd_vel."""
        return self._all(lambda driver: driver.cmd_vel.follow_listeners())

    def all_recorded(self, required: bool) -> Callable[[], bool]:
        """Return a check whether a recorder listens to all commands and poses, if required.

        A recorder discovers the processes of a fleet one by one: it may know this process before
        it knows the robots. If it is not required, the check also passes without a recorder.
        """

        def is_recorded(driver: SiToUni) -> bool:
            return self._recorder_listens(driver.cmd_vel.topic) and self._recorder_listens(
                self._poses.topic_of(driver.robot)
            )

        recorded = self._all(is_recorded)
        return lambda: (not required and not self._has_recorder()) or recorded()

    def _has_recorder(self) -> bool:
        own = self._node.get_namespace()  # a recorder of another namespace does not record here
        return any(
            name in RECORDER_NODES and (name != RECORDER_NODE or namespace == own)
            for name, namespace in self._node.get_node_names_and_namespaces()
        )

    def _all(self, holds: Callable[[SiToUni], bool]) -> Callable[[], bool]:
        """Return a function that checks a condition for each robot until it holds for all."""
        left = list(self._drivers)

        def all_hold() -> bool:
            left[:] = [driver for driver in left if not holds(driver)]
            return not left

        return all_hold

    def _recorder_listens(self, topic: str) -> bool:
        listeners = self._node.get_subscriptions_info_by_topic(topic)
        return any(info.node_name in RECORDER_NODES for info in listeners)

    def check(self) -> None:
        """Check one robot; report the result after a round over all robots.

        Checking a topic takes longer the more topics there are, so one step cannot check all
        robots of a large fleet.
        """
        now = time.monotonic()
        if not self._unchecked and now >= self._next_round:
            self._next_round = now + _ROUND_EVERY_S
            self._unchecked, self._found = list(self._drivers), {}
        if self._unchecked:
            self._check_robot(self._unchecked.pop())
            if not self._unchecked:
                self._report(now)

    def _check_robot(self, driver: SiToUni) -> None:
        robot, cmd_vel = driver.robot, driver.cmd_vel
        connected = cmd_vel.follow_listeners()
        if cmd_vel.mixed:
            self._found[Problem.MIXED, robot] = cmd_vel.mixed
        elif not connected:
            self._found[Problem.UNHEARD, robot] = ''
        own = driver.get_fully_qualified_name()
        if names := cmd_vel_topics.rivals(driver, cmd_vel.topic, own):
            self._found[Problem.RIVAL, robot] = names[0]
            return
        for one in driver.velocity_topics:
            if driver.count_publishers(one) > 1:
                topic = driver.resolve_topic_name(one)
                nodes = sorted(node.name for node in cmd_vel_topics.publishers(driver, topic))
                text = f'{topic} is published by {" and ".join(nodes)}'
                self._found[Problem.SEVERAL, robot] = text

    def _report(self, now: float) -> None:
        """Report what has lasted long enough, and has not been reported."""
        self._since = {key: self._since.get(key, now) for key in self._found}
        for problem in Problem:
            robots = [
                robot
                for key, since in self._since.items()
                if key not in self._reported and now - since >= problem.value[1]
                for kind, robot in [key]
                if kind is problem
            ]
            if robots:
                robots.sort()
                self._reported |= {(problem, robot) for robot in robots}
                text = _in_words(problem, robots, self._found[problem, robots[0]])
                self._node.get_logger().warning(text)


def _in_words(problem: Problem, robots: list[int], about: str) -> str:
    """Return a warning about some robots, with what is known about the first one."""
    others = robots[1:]
    if problem is Problem.MIXED:
        more = f' (and {len(others)} more topics)' if others else ''
        return f'{about}{more}; choose with --cmd-vel-type'
    if problem is Problem.UNHEARD:
        return f'nothing listens to cmd_vel of {robots_in_words(robots)}: commands do not arrive'
    if problem is Problem.RIVAL:
        return (
            f'another controller also commands {robots_in_words(robots)} ({about}); stop one of '
            'them'
        )
    more = f' (and that of {robots_in_words(others)})' if others else ''
    return (
        f'{about}{more}; the robot follows all of them: stop all but one ({cmd_vel_topics.KILLED})'
    )
