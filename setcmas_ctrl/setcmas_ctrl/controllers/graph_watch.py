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
    """A problem of robots in the graph: how long it must last, in s, and the text that reports it.

    `about` describes the problem of the first robot; `more` names the other robots that have it.
    """

    MIXED = _NOW_S, '{about}{more}; choose with --cmd-vel-type'
    UNHEARD = _SOON_S, 'nothing listens to cmd_vel of {robots}: commands do not arrive'
    # A killed process stays in the graph for a while.
    RIVAL = (
        _FORGOTTEN_AFTER_S,
        'another controller also commands {robots} ({about}); stop one of them',
    )
    SEVERAL = (
        _FORGOTTEN_AFTER_S,
        '{about}{more}; the robot follows all of them: stop all but one '
        f'({cmd_vel_topics.KILLED})',
    )


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
            lasts_s, text = problem.value
            new = self._since.keys() - self._reported
            robots = sorted(
                robot
                for kind, robot in new
                if kind is problem and now - self._since[kind, robot] >= lasts_s
            )
            if robots:
                self._reported |= {(problem, robot) for robot in robots}
                words, about = robots_in_words(robots), self._found[problem, robots[0]]
                more = f' (and so for {robots_in_words(robots[1:])})' if robots[1:] else ''
                text = text.format(robots=words, about=about, more=more)
                self._node.get_logger().warning(text)
