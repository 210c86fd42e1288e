"""Watch over a controller's robots in the ROS graph: listeners, rivals, latecomers."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy

from setcmas_ctrl.driving.driven_robot import SiToUni
from setcmas_ctrl.driving.fleet_discovery import robots_with_odometry
from setcmas_ctrl.driving.odometry import FleetOdometry
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.fleet.topics import RECORDER_NODES
from setcmas_simu.ros.fleet_topic import FleetListener

_ROUND_EVERY_S = 2.0
_LOOKS = 8  # at robots in a step
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
        self._next_round = 0.0
        self._to_look_at: list[SiToUni] = []
        self._unheard: set[int] = set()
        self._unheard_before: set[int] = set()
        self._rivals: dict[int, str] = {}
        self._unheard_since = 0.0
        self._unheard_told = False
        self._contested: set[int] = set()
        self._mixed_told: set[int] = set()
        self._known = set(range(1, odometry.poses.shape[1] + 1))

    def all_heard(self) -> Callable[[], bool]:
        """Return what tells whether every robot listens; the type of cmd_vel follows it."""
        return self._all(lambda follower: follower.cmd_vel.follow_listeners())

    def all_recorded(self) -> Callable[[], bool]:
        """Return what tells whether a recorder listens to every robot's commands and poses.

        A recorder finds the processes of a fleet one after another: that it knows this one does
        not mean that it knows the robots already.
        """
        return self._all(
            lambda follower: all(
                map(
                    self._recorder_listens,
                    (follower.cmd_vel.topic, self._odometry.topic_of(follower.robot)),
                )
            )
        )

    def recorded_if_they_can_be(self) -> Callable[[], bool]:
        """Return what tells the same, or true if there is no recorder."""
        recorded = self.all_recorded()
        return lambda: not self.has_recorder() or recorded()

    def has_recorder(self) -> bool:
        """Return whether there is a recorder."""
        return bool(set(RECORDER_NODES) & set(self._node.get_node_names()))

    def are_recorded(self, publishers: Iterable[Publisher]) -> bool:
        """Return whether a recorder gets all that some publishers send, or there is none."""
        return not self.has_recorder() or all(
            self._recorder_listens(one.topic_name, one.qos_profile.durability)
            for one in publishers
        )

    def _all(self, holds: Callable[[SiToUni], bool]) -> Callable[[], bool]:
        """Return what asks, of each robot until it is so, whether something holds."""
        left = list(self._followers)

        def all_hold() -> bool:
            left[:] = [follower for follower in left if not holds(follower)]
            return not left

        return all_hold

    def _recorder_listens(
        self, topic: str, durability: DurabilityPolicy = DurabilityPolicy.VOLATILE
    ) -> bool:
        listeners = self._node.get_subscriptions_info_by_topic(topic)
        # What was sent before comes to those who ask for it, as a recorder soon does.
        return any(
            info.node_name in RECORDER_NODES
            and durability in (DurabilityPolicy.VOLATILE, info.qos_profile.durability)
            for info in listeners
        )

    def check(self) -> None:
        """Look at some robots; tell what a round over all of them has shown.

        A look at a topic takes the longer the more topics there are, so that a step could not
        look at all robots of a large fleet.
        """
        now = time.monotonic()
        if not self._to_look_at and now >= self._next_round:
            self._next_round = now + _ROUND_EVERY_S
            self._to_look_at = list(self._followers)
            self._unheard, self._rivals = set(), {}
        some, self._to_look_at = self._to_look_at[:_LOOKS], self._to_look_at[_LOOKS:]
        for follower in some:
            self._look_at(follower, now)
        if some and not self._to_look_at:
            self._notice_unheard(now)
            self._notice_latecomers()
            self._notice_rivals()

    def _look_at(self, follower: SiToUni, now: float) -> None:
        robot, cmd_vel = follower.robot, follower.cmd_vel
        if not cmd_vel.follow_listeners():
            self._unheard.add(robot)
        if cmd_vel.mixed and robot not in self._mixed_told:
            self._mixed_told.add(robot)
            self._warn(f'{cmd_vel.mixed}; choose with --cmd-vel-type')
        # Who was killed before is seen for a while.
        is_over = now - self._begin > _FORGOTTEN_AFTER_S
        if is_over and robot not in self._contested and (names := cmd_vel.other_commanders()):
            self._rivals[robot] = names[0]

    def _notice_unheard(self, now: float) -> None:
        unheard = self._unheard
        if unheard != self._unheard_before:
            self._unheard_before, self._unheard_since = unheard, now
            self._unheard_told = False
        elif unheard and not self._unheard_told and now - self._unheard_since > _PATIENCE_S:
            self._unheard_told = True
            self._warn(
                f'nothing listens to cmd_vel of {robots_in_words(sorted(unheard))}, '
                'or only for messages of another type: commands do not arrive'
            )

    def _notice_latecomers(self) -> None:
        self._announced.take()
        present = {
            *robots_with_odometry(self._node, self._odometry.topic_of, self._known),
            *self._announced.robots,
        }
        if latecomers := present - self._known:
            self._known |= latecomers
            self._warn(
                f'{robots_in_words(sorted(latecomers), "have")} appeared; this controller does '
                'not control all of them: start it again, or with --nb-robots'
            )

    def _notice_rivals(self) -> None:
        if self._rivals:
            self._contested |= set(self._rivals)
            self._warn(
                f'another controller commands {robots_in_words(sorted(self._rivals))} too '
                f'({next(iter(self._rivals.values()))}): they fight; stop one of them'
            )
