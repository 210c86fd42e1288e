"""What a simulator looks for: other simulators of its robots, missed steps, unread commands."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.ros import cmd_vel_topics
from setcmas_simu.ros.fleet_node import FleetNode

_LOOK_EVERY_S = 2.0
_DISCOVERY_S = {'LOCALHOST': 0.4}
_NETWORK_DISCOVERY_S = 1.0
_FORGOTTEN_AFTER_S = 6.0  # one second more than the lease in config/fastdds_network.xml


def refuse_second_simulator(
    node: FleetNode,
    robots: Sequence[int],
    topic_of: Callable[[int], str] = topics.odometry_topic,
    nb_own: int = 0,
    is_stopping: Callable[[], bool] = bool,
) -> None:
    """Wait for discovery; raise SetcmasError if others publish a robot's odometry.

    `nb_own` is the number of publishers that this process has already; `is_stopping` ends a wait.
    """

    def present() -> list[int]:
        return [robot for robot in robots if node.count_publishers(topic_of(robot)) > nb_own]

    discovery_range = os.environ.get('ROS_AUTOMATIC_DISCOVERY_RANGE', 'SUBNET')
    time.sleep(_DISCOVERY_S.get(discovery_range, _NETWORK_DISCOVERY_S))
    seen = present()
    if seen:
        # A killed process stays in the graph for a while.
        node.get_logger().info('other nodes publish odometry; waiting to see if they remain')
        deadline = time.monotonic() + _FORGOTTEN_AFTER_S
        while seen and time.monotonic() < deadline and not is_stopping():
            time.sleep(0.1)
            seen = present()
    if seen and not is_stopping():
        names = [one.name for one in cmd_vel_topics.publishers(node, topic_of(seen[0]))]
        raise SetcmasError(
            f'{robots_in_words(seen, "are")} already simulated in ROS domain '
            f'{os.environ.get("ROS_DOMAIN_ID", "0")} (node {names[0]} publishes odometry): '
            'stop the other simulator, or set another ROS_DOMAIN_ID'
        )


class SimulatorWatch:
    """Warns of missed steps, of other simulators, and of commands that the robots do not take."""

    def __init__(self, node: FleetNode, robots: Sequence[int], kind: str) -> None:
        """Watch robots of this process, which take a type of commands, by its name in options."""
        self._node = node
        self._robots = robots
        self._contested: set[int] = set()
        self._topics = [topics.robot_topic(robot, topics.CMD_VEL) for robot in robots]
        self._kind = kind
        self._suspects: set[str] = set()
        self._reported: set[str] = set()
        self._missed = 0
        self._period = self._last_step = self._next_look = self._next_warning = 0.0
        self._last_warning = time.monotonic()

    def end_step(self, now: float, period: float) -> None:
        """Look after a step at a time in s; the next one is to follow after a period in s."""
        if self._last_step and period == self._period:
            self._missed += max(0, round((now - self._last_step) / period) - 1)
        self._last_step, self._period = now, period
        if (real := time.monotonic()) >= self._next_look:
            self._next_look = real + _LOOK_EVERY_S
            self._warn_of_missed(real)
            self._warn_of_unread()
            self.warn_of_others()

    def _warn_of_missed(self, real: float) -> None:
        if self._missed and real >= self._next_warning:
            seconds = real - self._last_warning
            steps = 'step was' if self._missed == 1 else 'steps were'
            self._node.get_logger().warning(
                f'{self._missed} {steps} missed in the last {seconds:.0f} s: '
                'this machine is too busy for the simulation'
            )
            self._missed, self._last_warning = 0, real
            self._next_warning = real + 2 * seconds  # a busy machine stays busy

    def _warn_of_unread(self) -> None:
        """Warn once of senders that were there at the last look, too: some change their type."""
        types = dict(self._node.get_topic_names_and_types())
        found = {
            topic: sender
            for topic in self._topics
            if len(types.get(topic, ())) > 1
            for sender in cmd_vel_topics.publishers(self._node, topic)
            if sender.kind != self._kind
        }
        stay = found.keys() & self._suspects
        self._suspects = set(found)
        if new := sorted(stay - self._reported, key=self._topics.index):
            self._reported |= set(new)
            self._node.get_logger().warning(self._described(new, found[new[0]]))

    def warn_of_others(self) -> None:
        """Warn of another simulator that was there at the last look, too, and so is to stay.

        Two that start at the same moment do not see each other in `refuse_second_simulator`.
        """
        found = {
            robot
            for robot in self._robots
            if self._node.count_publishers(topics.odometry_topic(robot)) > 1
        }
        if staying := sorted(found & self._contested):
            self._robots = [robot for robot in self._robots if robot not in staying]
            topic = topics.odometry_topic(staying[0])
            names = [one.name for one in cmd_vel_topics.publishers(self._node, topic)]
            self._node.get_logger().warning(
                f'the odometry of {robots_in_words(staying)} has two publishers '
                f'({" and ".join(names)}): two simulators move each; stop one of them'
            )
        self._contested = found

    def _described(self, unread: Sequence[str], sender: cmd_vel_topics.Endpoint) -> str:
        topic = self._node.full_name(unread[0])
        more = f' and {len(unread) - 1} more' if len(unread) > 1 else ''
        other, own = cmd_vel_topics.type_name(sender.kind), cmd_vel_topics.type_name(self._kind)
        is_known = sender.kind in cmd_vel_topics.TYPES
        start = f'start simu with --cmd-vel-type {sender.kind}, or ' if is_known else ''
        return (
            f'{topic}{more}: {sender.name} sends {other}, but the robot takes {own}, so no '
            f'command arrives; {start}send {own}'
        )
