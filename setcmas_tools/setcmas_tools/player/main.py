"""Player process: publishes the messages of a bag as they were recorded.

Run as `ros2 run setcmas_tools player BAG`.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Collection
from pathlib import Path

from builtin_interfaces.msg import Time
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rosgraph_msgs.msg import Clock

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.ros import qos
from setcmas_simu.ros.process import FleetNode, RosProcess, node_main
from setcmas_tools.bags.reader import Bag, open_bag
from setcmas_tools.player.bag_cursor import BagCursor
from setcmas_tools.player.choice import Choice
from setcmas_tools.player.options import PlayerOptions
from setcmas_tools.player.player import Player
from setcmas_tools.player.restored_qos import is_latched, restored_qos
from setcmas_tools.player.robots_there import RobotsThere

_DISCOVERY_S = 1.0
_FORGOTTEN_AFTER_S = 6.0  # a second more than the lease in config/fastdds_network.xml
_SETTLED_S = 0.5
_LONGEST_SETTLING_S = 3.0
_LAST_WORDS_S = 2.0
_LOOK_S = 1.0


def main(argv: list[str] | None = None) -> int:
    """Play; returns the exit status."""
    parser = argparse.ArgumentParser(prog='player', description=__doc__)
    parser.add_argument('bag', type=Path, metavar='BAG', help='folder or file of the bag')
    PlayerOptions.add_to(parser)
    return node_main(parser, _play_bag, argv)


def _play_bag(process: RosProcess, args: argparse.Namespace) -> int:
    options = PlayerOptions.of(args)
    if args.bag.suffix in ('.bag', '.active'):
        raise SetcmasError(f"'{args.bag}' is a ROS 1 bag; it must be a rosbag2 one to be played")
    with open_bag(args.bag) as bag:
        return _play(process, bag, options)


def _play(process: RosProcess, bag: Bag, options: PlayerOptions) -> int:
    choice = Choice(bag, options.topics, options.clock)
    latched = {topic for topic in choice.classes if is_latched(topic.offered_qos)}
    cursor = BagCursor(bag, choice.classes, latched)
    if options.start > cursor.duration:
        raise SetcmasError(
            f'--start is {options.start:g} s; it must be at most {cursor.duration:.1f} s, '
            'the length of the bag'
        )
    node = FleetNode(topics.PLAYER_NODE)
    there = RobotsThere(node, [topic.name for topic in choice.classes])
    for line in [*bag.notices, *choice.notes]:
        print(line, file=sys.stderr, flush=True)
    _refuse_robots(process, there)
    publishers = {
        topic: node.create_publisher(kind, topic.name, restored_qos(topic.offered_qos))
        for topic, kind in choice.classes.items()
    }
    player = Player(process, cursor, publishers, options.rate)
    player.on_tick = _Beside(node, there, bag.start_ns if options.clock else None).tick
    _settle(process, publishers.values())
    topics_text = 'topic' if len(publishers) == 1 else 'topics'
    print(f'playing {len(publishers)} {topics_text}, {cursor.duration:.1f} s', flush=True)
    reason = player.play(options.start, options.loop)
    _wait_until_sent(publishers.values())
    messages_text = 'message' if player.count == 1 else 'messages'
    print(f'played {player.count:,} {messages_text}', flush=True)
    if reason:
        print(f'error: playing has ended: {reason}', file=sys.stderr, flush=True)
    return int(bool(reason))


def _refuse_robots(process: RosProcess, there: RobotsThere) -> None:
    """Wait until others have had time to show up; whoever was killed stays for a while.

    Raises:
        SetcmasError: One of the robots is there.
    """
    process.spin_until(lambda: False, _DISCOVERY_S)
    if there.before():
        process.spin_until(lambda: not there.before(), _FORGOTTEN_AFTER_S)
    if reason := there.before():
        raise SetcmasError(f'{reason}; stop that first, or set another ROS_DOMAIN_ID')


def _settle(process: RosProcess, publishers: Collection[Publisher]) -> None:
    """Wait until those who listen, such as a recorder, have found the topics."""
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


def _wait_until_sent(publishers: Collection[Publisher]) -> None:
    deadline = time.monotonic() + _LAST_WORDS_S
    for publisher in publishers:
        left = max(0.0, deadline - time.monotonic())
        publisher.wait_for_all_acked(Duration(seconds=left))


class _Beside:
    """What happens beside the messages: the clock, and a look whether robots have come."""

    def __init__(self, node: Node, there: RobotsThere, clock_from_ns: int | None) -> None:
        """Prepare; the clock shows the time of the bag, which begins at a time in ns."""
        self._there = there
        self._from_ns = clock_from_ns
        self._clock = None
        if clock_from_ns is not None:
            self._clock = node.create_publisher(Clock, topics.CLOCK, qos.CLOCK)
        self._next_look = time.monotonic() + _LOOK_S

    def tick(self, at: float) -> str:
        """Publish the clock; returns who has one of the robots, empty if nobody."""
        if self._clock and self._from_ns is not None:
            seconds, nanoseconds = divmod(self._from_ns + round(at * 1e9), 10**9)
            self._clock.publish(Clock(clock=Time(sec=seconds, nanosec=nanoseconds)))
        now = time.monotonic()
        if now < self._next_look:
            return ''
        self._next_look = now + _LOOK_S
        return self._there.beside()


if __name__ == '__main__':
    sys.exit(main())
