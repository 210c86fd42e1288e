"""Watch over a controller's robots in the ROS graph: listeners, rivals, latecomers."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable

from rclpy.node import Node

from setcmas_ctrl.controller.si_to_uni import SiToUni
from setcmas_ctrl.fleet.discovery import robots_with_odometry
from setcmas_ctrl.fleet.odometry import FleetOdometry
from setcmas_simu.fleet.fleet import format_robots
from setcmas_simu.fleet.topics import RECORDER_NODES
from setcmas_simu.ros.fleet_topic import FleetListener

_CHECK_EVERY_S = 2.0
_PATIENCE_S = 2.0  # a robot that nobody hears for longer is told
_FORGOTTEN_AFTER_S = 6.0  # a second more than the lease in config/fastdds_network.xml


class GraphWatch:
    """Looks at the graph now and then, and tells each oddity once."""

    def __init__(
        self,
        node: Node,
        odometry: FleetOdometry,
        announced: FleetListener,
        followers: list[SiToUni],
        warn: Callable[[str], None],
    ) -> None:
        """Prepare.

        Args:
            node: The node through which the graph is seen.
            odometry: The fleet that this process knows.
            announced: The robots that are announced, those that come later too.
            followers: The si_to_uni nodes of this process.
            warn: Shows a message to the user.
        """
        self._node = node
        self._odometry = odometry
        self._announced = announced
        self._followers = followers
        self._warn = warn
        self._begin = time.monotonic()
        self._next_check = 0.0
        self._unheard: set[int] = set()
        self._unheard_since = 0.0
        self._unheard_told = False
        self._contested: set[int] = set()
        self._mixed_told: set[int] = set()
        self._known = set(range(1, odometry.poses.shape[1] + 1))

    def unheard_robots(self) -> set[int]:
        """Return the robots that do not listen; the type of cmd_vel follows those that do."""
        return {f.robot for f in self._followers if not f.cmd_vel.follow_listeners()}

    def is_recorded(self) -> bool:
        """Return whether a recorder listens to every robot's commands, and to its poses.

        A recorder finds the processes of a fleet one after another: that it knows this one does
        not mean that it knows the robots already.
        """
        return all(
            self._recorder_listens(topic)
            for follower in self._followers
            for topic in (follower.cmd_vel.topic, self._odometry.topic_of(follower.robot))
        )

    def is_recorded_if_it_can_be(self) -> bool:
        """Return the same, or true if there is no recorder."""
        return not self.has_recorder() or self.is_recorded()

    def has_recorder(self) -> bool:
        """Return whether there is a recorder."""
        return bool(set(RECORDER_NODES) & set(self._node.get_node_names()))

    def are_recorded(self, names: Iterable[str]) -> bool:
        """Return whether a recorder listens to some topics, or there is none."""
        return not self.has_recorder() or all(map(self._recorder_listens, names))

    def _recorder_listens(self, topic: str) -> bool:
        listeners = self._node.get_subscriptions_info_by_topic(topic)
        return any(info.node_name in RECORDER_NODES for info in listeners)

    def check(self) -> None:
        """Look again, if the last look is some time ago."""
        now = time.monotonic()
        if now >= self._next_check:
            self._next_check = now + _CHECK_EVERY_S
            self._notice_unheard(now)
            self._notice_mixed_types()
            self._notice_latecomers()
            if now - self._begin > _FORGOTTEN_AFTER_S:  # who was killed before is not seen then
                self._notice_rivals()

    def _notice_unheard(self, now: float) -> None:
        unheard = self.unheard_robots()
        if unheard != self._unheard:
            self._unheard, self._unheard_since = unheard, now
            self._unheard_told = False
        elif unheard and not self._unheard_told and now - self._unheard_since > _PATIENCE_S:
            self._unheard_told = True
            self._warn(
                f'nothing listens to cmd_vel of robots {format_robots(sorted(unheard))} with a '
                'type that is published: they will not move'
            )

    def _notice_mixed_types(self) -> None:
        for follower in self._followers:
            if follower.cmd_vel.mixed and follower.robot not in self._mixed_told:
                self._mixed_told.add(follower.robot)
                self._warn(f'{follower.cmd_vel.mixed}; choose with --cmd-vel-type')

    def _notice_latecomers(self) -> None:
        present = set(robots_with_odometry(self._node, self._odometry.topic_of))
        self._announced.take()
        present |= set(self._announced.robots)
        if latecomers := present - self._known:
            self._known |= latecomers
            self._warn(
                f'robots {format_robots(sorted(latecomers))} have appeared; this controller does '
                'not know them: start it again, or with --nb-robots, to include them'
            )

    def _notice_rivals(self) -> None:
        rivals = {
            follower.robot: names[0]
            for follower in self._followers
            if follower.robot not in self._contested
            and (names := follower.cmd_vel.other_commanders())
        }
        if rivals:
            self._contested |= set(rivals)
            self._warn(
                f'another controller commands robots {format_robots(sorted(rivals))} too '
                f'({next(iter(rivals.values()))}): they fight; stop one of them'
            )
