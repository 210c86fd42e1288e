"""Player process: publishes the messages of a bag as they were recorded.

Run as `ros2 run setcmas_tools player BAG`.
"""

from __future__ import annotations

import argparse
import os
import select
import sys
import time
from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from builtin_interfaces.msg import Time
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosbags.interfaces import Qos, QosDurability, QosReliability, QosTime
from rosgraph_msgs.msg import Clock

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.reports.reports import LineDecoder
from setcmas_simu.ros import cmd_vel_topics, qos
from setcmas_simu.ros.message_class import NoPythonTypeError, message_class
from setcmas_simu.ros.process import FleetNode, RosProcess, node_main
from setcmas_tools.bags.bag import Bag, BagTopic, open_bag
from setcmas_tools.bags.recording_options import PauseToggled, PlayerOptions

_COMMANDS = (
    topics.PAUSE,
    topics.RESET,
    topics.PAUSED.strip('/'),
    topics.GUARD_STATE,
    topics.BRIDGE_STATE,
    topics.POSE_STATE,
)
_COMMANDS_OF_FLEETS = (
    topics.EMERGENCY_STOP,
    topics.EMERGENCY_STOPPED,
    topics.EMULATED_FAULT,
    topics.FLEET_TIME,
)
_COMMAND_BEGIN = 'cmd_'  # of any stack: cmd_vel, cmd_cart_vel, cmd_vel_nav
_COMMAND_TYPES = (
    'ackermann_msgs/msg/AckermannDrive',
    'ackermann_msgs/msg/AckermannDriveStamped',
    'geometry_msgs/msg/Twist',
    'geometry_msgs/msg/TwistStamped',
    'sensor_msgs/msg/Joy',  # its button starts experiments
    'trajectory_msgs/msg/JointTrajectory',
)


def is_command(name: str, msgtype: str) -> bool:
    """Return whether robots or their controllers may act on a topic.

    These topics are never played: no robot may move because of a recording, not even a robot
    that is switched on later.
    """
    last = name.rpartition('/')[2]
    if msgtype in _COMMAND_TYPES or name in _COMMANDS_OF_FLEETS or last in _COMMANDS:
        return True
    return last.startswith(_COMMAND_BEGIN)


def played_topics(bag: Bag, own_clock: bool) -> tuple[dict[BagTopic, Any], list[str]]:
    """Return the message class of each topic to play, and a line for each reason to omit topics.

    With its own clock, the player publishes /clock itself.

    Raises:
        SetcmasError: No topic can be played.
    """
    classes: dict[BagTopic, Any] = {}
    left_out: defaultdict[str, list[str]] = defaultdict(list)
    for topic in bag.topics:
        reason = _objection(topic, own_clock)
        if any(topic.name == other.name for other in classes):
            reason = reason or 'recorded with two types'
        try:
            classes |= {} if reason else {topic: message_class(topic.type.name)}
        except NoPythonTypeError as error:
            reason = str(error)
        if reason:
            left_out[reason].append(topic.name)
    notes = [f'not played: {_listed(names)} ({why})' for why, names in left_out.items()]
    if not classes:
        raise SetcmasError('; '.join(['no topic is left to play', *notes]))
    return classes, notes


def _objection(topic: BagTopic, own_clock: bool) -> str:
    """Return why a topic is never played; empty if it may be."""
    if is_command(topic.name, topic.type.name):
        return 'no robot moves because of a recording'
    if topic.name in (topics.PARAMETER_EVENTS, topics.ROSOUT):
        return 'they belong to the recorded programs'
    return '--clock takes its place' if own_clock and topic.name == topics.CLOCK else ''


def _listed(names: list[str]) -> str:
    first = ', '.join(names[:3])
    return f'{first} and {len(names) - 3} more' if len(names) > 3 else first


_INFINITE_NS = 2**31 * 10**9
_KEPT = 1000  # messages of a latched topic for late subscribers


def restored_qos(offered: Sequence[Qos]) -> QoSProfile:
    """Return a profile for all subscribers that matched a recorded publisher.

    Bags recorded from the network store no depth; this one loses nothing.
    """
    best_effort = offered and all(one.reliability == QosReliability.BEST_EFFORT for one in offered)
    latched = any(one.durability == QosDurability.TRANSIENT_LOCAL for one in offered)
    return QoSProfile(
        depth=_KEPT,
        reliability=ReliabilityPolicy.BEST_EFFORT if best_effort else ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        deadline=_duration([one.deadline for one in offered]),
        lifespan=_duration([one.lifespan for one in offered]),
    )


def _duration(times: Sequence[QosTime]) -> Duration:
    longest = max((time.sec * 10**9 + time.nsec for time in times), default=0)
    return Duration(nanoseconds=longest if longest < _INFINITE_NS else 0)  # 0 is infinite, too


class RobotConflict:
    """Finds other nodes that publish or command the robots of a recording."""

    def __init__(self, node: Node, names: Collection[str]) -> None:
        """Take a node, which sees the graph, and the names of the topics to play."""
        self._node = node
        self._names = sorted(name for name in names if topics.robot_of(name))
        self._robots = sorted({topics.robot_of(name) or 0 for name in names} - {0})

    def before_playing(self) -> str:
        """Return which node uses a robot before playing starts; empty if none does."""
        return self._sender(self._names, 0) or self._listener()

    def while_playing(self) -> str:
        """Return which node but this player uses a robot; empty if none does."""
        return self._sender(filter(topics.is_odometry, self._names), 1) or self._listener()

    def _sender(self, names: Iterable[str], own: int) -> str:
        there = (name for name in names if self._node.count_publishers(name) > own)
        return next((f'another node publishes {name}' for name in there), '')

    def _listener(self) -> str:
        for robot in self._robots:
            topic = topics.robot_topic(robot, topics.CMD_VEL)
            if found := cmd_vel_topics.listeners(self._node, topic):
                name = topics.robot_name(robot)
                return f'{name} is in use: {found[0].full_name} listens to {topic}'
        return ''


class PlayClock:
    """The time in s since the first message of a recording.

    Attributes:
        paused: Whether the time stops.
    """

    def __init__(self, rate: float, now: float) -> None:
        """Start at a time of the steady clock in s, which this one is `rate` times as fast as."""
        self.paused = False
        self._rate = rate
        self._at = 0.0
        self._since = now

    def at(self, now: float) -> float:
        """Return the time in the recording at a time of the steady clock."""
        return self._at if self.paused else self._at + self._rate * (now - self._since)

    def wait_s(self, at: float, now: float) -> float:
        """Return the time in s until a time in the recording comes, at least 0."""
        return max(0.0, (at - self.at(now)) / self._rate)

    def toggle(self, now: float) -> None:
        """Pause, or resume."""
        self._at, self._since = self.at(now), now
        self.paused = not self.paused


_TICK_S = 0.025
_LOOK_S = 1.0


class Player:
    """Publishes the messages of a bag in time.

    Attributes:
        count: Number of messages that were published.
        reason: Why playing broke off; empty at the end of the bag, or after a request to stop.
    """

    def __init__(
        self, process: RosProcess, conflict: RobotConflict, rate: float, clock: Publisher | None
    ) -> None:
        """Prepare to play at a rate, 1 as recorded; None for no clock of the recording."""
        self.count = 0
        self.reason = ''
        self._process = process
        self._conflict = conflict
        self._clock_publisher = clock
        self._clock = PlayClock(rate, time.monotonic())
        self._next_tick = 0.0
        self._next_look = time.monotonic() + _LOOK_S
        self._keys: LineDecoder[PauseToggled] = LineDecoder(PauseToggled)
        self._stdin: int | None = sys.stdin.fileno() if sys.stdin else None

    def play(self, bag: Bag, publishers: Mapping[BagTopic, Publisher]) -> None:
        """Play topics of a bag to its end, with a publisher for each."""
        for topic, time_ns, data in bag.messages(publishers):
            if not self._waits_until(time_ns, bag.start_ns):
                return
            publishers[topic].publish(data)
            self.count += 1

    def _waits_until(self, time_ns: int, start_ns: int) -> bool:
        """Return whether playing goes on when this time of the bag has come."""
        while not (self._process.stopping or self.reason):
            now = time.monotonic()
            if now >= self._next_tick:
                self._next_tick = now + _TICK_S
                self._tick(start_ns + round(self._clock.at(now) * 1e9))
            wait = self._clock.wait_s((time_ns - start_ns) / 1e9, now)
            if not (wait or self._clock.paused):
                return True
            self._take_keys(_TICK_S if self._clock.paused else min(wait, _TICK_S))
        return False

    def _tick(self, time_ns: int) -> None:
        if self._clock_publisher:
            seconds, nanoseconds = divmod(time_ns, 10**9)
            self._clock_publisher.publish(Clock(clock=Time(sec=seconds, nanosec=nanoseconds)))
        if time.monotonic() >= self._next_look:
            self._next_look = time.monotonic() + _LOOK_S
            self.reason = self._conflict.while_playing()
        self._process.serve_at_times()

    def _take_keys(self, timeout_s: float) -> None:
        """Wait for a time in s, or until a key is pressed."""
        if self._stdin is None:
            time.sleep(timeout_s)
        elif select.select([self._stdin], [], [], timeout_s)[0]:
            data = os.read(self._stdin, 4096)
            if not data:  # no terminal
                self._stdin = None
            for _ in self._keys.feed(data):
                now = time.monotonic()
                self._clock.toggle(now)
                state = 'paused' if self._clock.paused else 'playing on'
                print(f'{state} at {self._clock.at(now):.1f} s', flush=True)


_DISCOVERY_S = 1.0
_FORGOTTEN_AFTER_S = 6.0  # a second more than the lease in config/fastdds_network.xml
_SETTLED_S = 0.5
_LONGEST_SETTLING_S = 3.0
_LAST_MESSAGES_S = 2.0


def main(argv: list[str] | None = None) -> int:
    """Play; return the exit status."""
    parser = argparse.ArgumentParser(prog='player', description=__doc__)
    parser.add_argument('bag', type=Path, metavar='BAG', help='folder or file of the bag')
    PlayerOptions.add_to(parser)
    return node_main(parser, _play_bag, argv)


def _play_bag(process: RosProcess, args: argparse.Namespace) -> int:
    if args.bag.suffix in ('.bag', '.active'):
        raise SetcmasError(f"'{args.bag}' is a ROS 1 bag; only rosbag2 bags can be played")
    with open_bag(args.bag) as bag:
        return _play(process, bag, PlayerOptions.of(args))


def _play(process: RosProcess, bag: Bag, options: PlayerOptions) -> int:
    classes, notes = played_topics(bag, options.clock)
    node = FleetNode(topics.PLAYER_NODE)
    process.add(node)
    conflict = RobotConflict(node, [topic.name for topic in classes])
    for line in [*bag.notices, *notes]:
        print(line, file=sys.stderr, flush=True)
    _refuse_robots(process, conflict)
    publishers = {
        topic: node.create_publisher(kind, topic.name, restored_qos(topic.offered_qos))
        for topic, kind in classes.items()
    }
    clock = node.create_publisher(Clock, topics.CLOCK, qos.CLOCK) if options.clock else None
    _settle(process, [*publishers.values(), *([clock] if clock else [])])
    topics_text = 'topic' if len(publishers) == 1 else 'topics'
    seconds = (bag.end_ns - bag.start_ns) / 1e9
    print(f'playing {len(publishers)} {topics_text}, {seconds:.1f} s', flush=True)
    player = Player(process, conflict, options.rate, clock)
    player.play(bag, publishers)
    deadline = time.monotonic() + _LAST_MESSAGES_S
    for publisher in publishers.values():
        publisher.wait_for_all_acked(Duration(seconds=max(0.0, deadline - time.monotonic())))
    messages_text = 'message' if player.count == 1 else 'messages'
    print(f'played {player.count:,} {messages_text}', flush=True)
    if player.reason:
        print(f'error: playing stopped: {player.reason}', file=sys.stderr, flush=True)
    return int(bool(player.reason))


def _refuse_robots(process: RosProcess, conflict: RobotConflict) -> None:
    """Wait until other nodes have been discovered; killed ones remain visible for a while.

    Raises:
        SetcmasError: One of the robots is in use.
    """
    process.spin_until(lambda: False, _DISCOVERY_S)
    if conflict.before_playing():
        process.spin_until(lambda: not conflict.before_playing(), _FORGOTTEN_AFTER_S)
    if reason := conflict.before_playing():
        raise SetcmasError(f'{reason}; stop that first, or set another ROS_DOMAIN_ID')


def _settle(process: RosProcess, publishers: Collection[Publisher]) -> None:
    """Wait until subscribers, such as a recorder, have found the topics."""
    begin = since = time.monotonic()
    known = -1
    while not process.stopping:
        now = time.monotonic()
        found = sum(publisher.get_subscription_count() for publisher in publishers)
        if found != known:
            known, since = found, now
        if now - since > _SETTLED_S or now - begin > _LONGEST_SETTLING_S:
            return
        time.sleep(0.02)


if __name__ == '__main__':
    sys.exit(main())
