"""Monitor of the ROS graph: robots that do not listen, other controllers, new robots."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from rclpy.node import Node

from setcmas_ctrl.controllers.fleet_discovery import robots_with_odometry
from setcmas_ctrl.fleet_poses import FleetPoses
from setcmas_ctrl.si_to_uni_node import SiToUni
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.fleet.topics import RECORDER_NODE, RECORDER_NODES
from setcmas_simu.ros import cmd_vel_topics
from setcmas_simu.ros.fleet_topic import FleetListener

_ROUND_EVERY_S = 2.0
_MOST_CHECKS = 2  # robots checked per step
_PATIENCE_S = 2.0  # time without a listener before a warning
_FORGOTTEN_AFTER_S = 6.0  # one second more than the lease in config/fastdds_network.xml


class GraphWatch:
    """Checks the graph now and then, and reports each problem once.

    Attributes:
        is_of_one: Whether this process is to have one robot alone, whichever others appear.
    """

    is_of_one = False

    def __init__(
        self,
        node: Node,
        poses: FleetPoses,
        topic_of: Callable[[int], str],
        announced: FleetListener,
        drivers: list[SiToUni],
        warn: Callable[[str], None],
    ) -> None:
        """Begin; new robots are found by their topics, those of known ones are in `poses`."""
        self._node = node
        self._topic_of = topic_of
        self._own = cmd_vel_topics.own_participant(node)
        self._poses = poses
        self._announced = announced
        self._drivers = drivers
        self._warn = warn
        self._begin = time.monotonic()
        self._next_round = 0.0
        self._unchecked: list[SiToUni] = []
        self._unconnected: set[int] = set()
        self._unconnected_before: set[int] = set()
        self._rivals: dict[int, str] = {}
        self._report_unconnected_at = 0.0
        self._contested: set[int] = set()
        self._several: dict[int, str] = {}
        self._several_since: dict[int, float] = {}
        self._mixed: dict[int, str] = {}
        self._mixed_reported: set[int] = set()
        self._known = set(range(1, poses.poses.shape[1] + 1))
        self._latecomers: set[int] = set()

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
        """Check some robots; report the result after a round over all robots.

        Checking a topic takes longer the more topics there are, so one step cannot check all
        robots of a large fleet.
        """
        now = time.monotonic()
        if not self._unchecked and now >= self._next_round:
            self._next_round = now + _ROUND_EVERY_S
            self._unchecked = list(self._drivers)
            self._unconnected, self._rivals, self._mixed, self._several = set(), {}, {}, {}
        some, self._unchecked = self._unchecked[:_MOST_CHECKS], self._unchecked[_MOST_CHECKS:]
        for driver in some:
            self._check_robot(driver, now)
        if some and not self._unchecked:
            self._notice_mixed()
            self._notice_unconnected(now)
            if not self.is_of_one:
                self._notice_latecomers()
            self._notice_rivals()
            self._notice_several()

    def _check_robot(self, driver: SiToUni, now: float) -> None:
        robot, cmd_vel = driver.robot, driver.cmd_vel
        connected = cmd_vel.follow_listeners()
        if cmd_vel.mixed:
            self._mixed[robot] = cmd_vel.mixed
        elif not connected:
            self._unconnected.add(robot)
        # A killed process stays in the graph for a while.
        is_due = now - self._begin > _FORGOTTEN_AFTER_S and robot not in self._contested
        if is_due and (names := cmd_vel.other_commanders(self._own)):
            self._rivals[robot] = names[0]
        elif robot not in self._contested:
            self._look_for_several(driver, now)

    def _look_for_several(self, driver: SiToUni, now: float) -> None:
        """Remember who publishes the velocities of a robot if it has been several for a while."""
        contested = [one for one in driver.velocity_topics if driver.count_publishers(one) > 1]
        if not contested:
            self._several_since.pop(driver.robot, None)
        elif now - self._several_since.setdefault(driver.robot, now) > _FORGOTTEN_AFTER_S:
            topic = driver.resolve_topic_name(contested[0])
            names = sorted(one.name for one in cmd_vel_topics.publishers(driver, topic))
            self._several[driver.robot] = f'{topic} is published by {" and ".join(names)}'

    def _notice_mixed(self) -> None:
        if new := [robot for robot in self._mixed if robot not in self._mixed_reported]:
            self._mixed_reported |= set(new)
            more = f' (and {len(new) - 1} more topics)' if len(new) > 1 else ''
            self._warn(f'{self._mixed[new[0]]}{more}; choose with --cmd-vel-type')

    def _notice_unconnected(self, now: float) -> None:
        if self._unconnected != self._unconnected_before:
            self._unconnected_before = self._unconnected
            self._report_unconnected_at = now + _PATIENCE_S
        elif self._unconnected and now > self._report_unconnected_at:
            self._report_unconnected_at = math.inf
            self._warn(
                f'nothing listens to cmd_vel of {robots_in_words(sorted(self._unconnected))}: '
                'commands do not arrive'
            )

    def _notice_latecomers(self) -> None:
        self._announced.take()
        present = {
            *robots_with_odometry(self._node, self._topic_of, self._known),
            *self._announced.robots,
        }
        latecomers = present - self._known
        complete, self._latecomers = latecomers == self._latecomers, latecomers
        if latecomers and complete:  # DDS discovers robots one after another
            self._known |= latecomers
            self._warn(
                f'{robots_in_words(sorted(latecomers), "have")} appeared; this controller '
                'does not control all of them: restart it, if necessary with --nb-robots'
            )

    def _notice_rivals(self) -> None:
        if self._rivals:
            self._contested |= set(self._rivals)
            self._warn(
                f'another controller also commands {robots_in_words(sorted(self._rivals))} '
                f'({next(iter(self._rivals.values()))}); stop one of them'
            )

    def _notice_several(self) -> None:
        if self._several:
            self._contested |= set(self._several)
            (_, text), *others = sorted(self._several.items())
            more = robots_in_words([robot for robot, _ in others]) if others else ''
            self._warn(
                f'{text}{more and f" (and that of {more})"}; the robot follows all of them: '
                'stop all but one'
            )
