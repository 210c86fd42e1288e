"""Player process: publishes the messages of a bag as they were recorded.

Run as `ros2 run setcmas_tools player BAG`.
"""

from __future__ import annotations

import argparse
import os
import select
import sys
import time
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from pathlib import Path

from builtin_interfaces.msg import Time
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosbags.interfaces import Qos, QosDurability, QosReliability, QosTime
from rosgraph_msgs.msg import Clock

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.reports.reports import LineDecoder
from setcmas_simu.ros import cmd_vel_topics, qos
from setcmas_simu.ros.fleet_topic import FleetListener
from setcmas_simu.ros.process import FleetNode, RosProcess, node_main
from setcmas_tools.bags.bag import Bag, BagTopic, open_bag
from setcmas_tools.bags.playback import BagCursor, PlayClock, Played, played_topics
from setcmas_tools.bags.recording_options import PauseToggled, PlayerOptions

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
        """Start listening.

        Args:
            node: Sees the graph.
            names: The topics to play.
        """
        self._node = node
        self._names = sorted(name for name in names if topics.robot_of(name))
        self._robots = sorted({topics.robot_of(name) or 0 for name in names} - {0})
        self._fleet = FleetListener(node)

    def before_playing(self) -> str:
        """Return which node uses a robot before playing starts; empty if none does."""
        self._fleet.take()
        for source, announced in self._fleet.by_source.items():
            if both := sorted(set(self._robots) & set(announced.robots)):
                return f'{robots_in_words(both, "are")} in use: a {source} runs them'
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


_LONGEST_WAIT_S = 0.025


class Player:
    """Publishes the messages of a cursor.

    Attributes:
        count: Number of messages that were published.
    """

    def __init__(
        self,
        process: RosProcess,
        cursor: BagCursor,
        publishers: Mapping[BagTopic, Publisher],
        rate: float,
        on_tick: Callable[[float], str],
    ) -> None:
        """Prepare to play from the start of the recording.

        Args:
            process: Asks to stop.
            cursor: Reads the messages.
            publishers: The publisher of each topic.
            rate: Playback speed; 1 is as recorded.
            on_tick: Called at least every 25 ms with the time in the recording in s; returns
                why playing must end, empty if it may go on.
        """
        self.count = 0
        self._process = process
        self._cursor = cursor
        self._publishers = publishers
        self._clock = PlayClock(rate, time.monotonic())
        self._on_tick = on_tick
        self._keys: LineDecoder[PauseToggled] = LineDecoder(PauseToggled)
        self._stdin: int | None = sys.stdin.fileno() if sys.stdin else None

    def play(self) -> str:
        """Play to the end.

        Returns:
            Why playing broke off; empty at the end of the bag, or after a request to stop.
        """
        while not self._process.stopping:
            now = time.monotonic()
            at = min(self._clock.at(now), self._cursor.duration)
            self._publish(self._cursor.until(at))
            if reason := self._on_tick(at):
                return reason
            self._process.serve_at_times()
            wait = _LONGEST_WAIT_S
            if not self._clock.paused:
                if self._cursor.next_s is None:
                    break
                wait = min(wait, self._clock.wait_s(self._cursor.next_s, now))
            self._take_keys(wait)
        return ''

    def _publish(self, messages: Iterable[Played]) -> None:
        for topic, data in messages:
            self._publishers[topic].publish(data)
            self.count += 1
            if self._process.stopping:
                return

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
_LOOK_S = 1.0


def main(argv: list[str] | None = None) -> int:
    """Play; return the exit status."""
    parser = argparse.ArgumentParser(prog='player', description=__doc__)
    parser.add_argument('bag', type=Path, metavar='BAG', help='folder or file of the bag')
    PlayerOptions.add_to(parser)
    return node_main(parser, _play_bag, argv)


def _play_bag(process: RosProcess, args: argparse.Namespace) -> int:
    options = PlayerOptions.of(args)
    if args.bag.suffix in ('.bag', '.active'):
        raise SetcmasError(f"'{args.bag}' is a ROS 1 bag; only rosbag2 bags can be played")
    with open_bag(args.bag) as bag:
        return _play(process, bag, options)


def _play(process: RosProcess, bag: Bag, options: PlayerOptions) -> int:
    classes, notes = played_topics(bag, options.clock)
    cursor = BagCursor(bag, classes)
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
    player = Player(
        process, cursor, publishers, options.rate, _tick(conflict, clock, bag.start_ns)
    )
    _settle(process, [*publishers.values(), *([clock] if clock else [])])
    topics_text = 'topic' if len(publishers) == 1 else 'topics'
    print(f'playing {len(publishers)} {topics_text}, {cursor.duration:.1f} s', flush=True)
    reason = player.play()
    deadline = time.monotonic() + _LAST_MESSAGES_S
    for publisher in publishers.values():
        publisher.wait_for_all_acked(Duration(seconds=max(0.0, deadline - time.monotonic())))
    messages_text = 'message' if player.count == 1 else 'messages'
    print(f'played {player.count:,} {messages_text}', flush=True)
    if reason:
        print(f'error: playing stopped: {reason}', file=sys.stderr, flush=True)
    return int(bool(reason))


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


def _tick(
    conflict: RobotConflict, clock: Publisher | None, from_ns: int
) -> Callable[[float], str]:
    """Return the function that publishes the clock and looks for robots that appear.

    Args:
        conflict: Finds the robots.
        clock: Publishes the clock; None to publish none.
        from_ns: Time of the bag's start in ns.
    """
    next_look = time.monotonic() + _LOOK_S

    def tick(at: float) -> str:
        nonlocal next_look
        if clock:
            seconds, nanoseconds = divmod(from_ns + round(at * 1e9), 10**9)
            clock.publish(Clock(clock=Time(sec=seconds, nanosec=nanoseconds)))
        if time.monotonic() < next_look:
            return ''
        next_look = time.monotonic() + _LOOK_S
        return conflict.while_playing()

    return tick


if __name__ == '__main__':
    sys.exit(main())
