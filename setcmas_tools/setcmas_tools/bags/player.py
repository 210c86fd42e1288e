"""Player process: publishes the messages of a bag as they were recorded.

Run as `ros2 run setcmas_tools player BAG`.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosbags.interfaces import QosDurability

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.ros import cmd_vel_topics
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.messages import NoPythonTypeError, message_class, wait_until_received
from setcmas_simu.ros.polling import RequestWait
from setcmas_simu.ros.process import RosProcess, node_main
from setcmas_tools.bags.bag_reader import Bag, BagTopic, open_bag
from setcmas_tools.bags.recording_options import PlayerOptions

_OF_ROBOTS = (
    topics.ODOM,
    topics.POSE,
    topics.TRIG_ODOM,
    topics.TRIG_EVENT,
    topics.LINKS,
    topics.MESSAGE,
)
_OF_FLEETS = (
    topics.FLEET,
    topics.DIAGNOSTICS,
    topics.TASK,
    topics.COMMUNICATION_GRAPH,
    topics.TF,
)
_DRAWING = 'visualization_msgs/msg/Marker'


def is_shown(name: str, msgtype: str) -> bool:
    """Return whether a topic is for those who watch: poses, communication, or drawings.

    No other topic is played: no robot may move because of a recording, not even a robot that is
    switched on later.
    """
    is_robots = topics.robot_of(name) is not None and name.rpartition('/')[2] in _OF_ROBOTS
    return is_robots or name in _OF_FLEETS or msgtype.removesuffix('Array') == _DRAWING


def played_topics(bag: Bag) -> tuple[dict[BagTopic, Any], list[str]]:
    """Return the message class of each topic to play, and a line for each reason to omit topics.

    Raises:
        SetcmasError: No topic can be played.
    """
    classes: dict[BagTopic, Any] = {}
    left_out: defaultdict[str, list[str]] = defaultdict(list)
    for topic in bag.topics:
        if not is_shown(topic.name, topic.msgtype):
            left_out['only poses, communication and drawings are'].append(topic.name)
        elif any(topic.name == other.name for other in classes):
            left_out['recorded with two types'].append(topic.name)
        else:
            try:
                classes[topic] = message_class(topic.msgtype)
            except NoPythonTypeError as error:
                left_out[str(error)].append(topic.name)
    notes = [f'not played: {", ".join(names)} ({why})' for why, names in left_out.items()]
    if not classes:
        raise SetcmasError('; '.join(['no topic is left to play', *notes]))
    return classes, notes


_KEPT = 1000  # messages of a latched topic for late subscribers


def played_qos(topic: BagTopic) -> QoSProfile:
    """Return a profile that suits all subscribers; it loses nothing."""
    latched = any(one.durability == QosDurability.TRANSIENT_LOCAL for one in topic.offered_qos)
    durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
    return QoSProfile(depth=_KEPT, durability=durability)


def robots_in_use(node: Node, names: Iterable[str], own: int = 0) -> str:
    """Return which other node publishes a topic or listens for commands; empty if none does.

    Args:
        node: A node, which sees the graph.
        names: Topics, of which those of robots count.
        own: Number of publishers of each topic that are this player's.
    """
    robots = {name: robot for name in names if (robot := topics.robot_of(name))}
    for name in sorted(robots):
        if node.count_publishers(name) > own:
            return f'another node publishes {name}'
    for robot in sorted(set(robots.values())):
        topic = topics.robot_topic(robot, topics.CMD_VEL)
        if found := cmd_vel_topics.listeners(node, topic):
            name = topics.robot_name(robot)
            return f'{name} is in use: {found[0].name} listens to {topic}'
    return ''


_WAKE_S = 0.025
_LOOK_S = 1.0


def play(
    process: RosProcess,
    bag: Bag,
    publishers: Mapping[BagTopic, Publisher],
    rate: float,
    in_use: Callable[[], str],
) -> int:
    """Publish the messages of topics at their times, until the bag or the process ends.

    Args:
        process: This process, which answers requests meanwhile.
        bag: The recording.
        publishers: One for each topic to play.
        rate: Speed, 1 as recorded.
        in_use: Returns why playing must break off; empty if it need not.

    Returns:
        Number of published messages.

    Raises:
        SetcmasError: Playing broke off.
    """
    count = 0
    begin = time.monotonic()
    next_look = begin + _LOOK_S
    for topic, time_ns, data in bag.messages(publishers):
        due = begin + (time_ns - bag.start_ns) / 1e9 / rate
        while True:
            now = time.monotonic()
            if now >= next_look:
                next_look = now + _LOOK_S
                if reason := in_use():
                    raise SetcmasError(f'playing stopped: {reason}')
            if process.stopping:
                return count
            if now >= due:
                break
            process.serve(min(due - now, _WAKE_S))
        publishers[topic].publish(data)
        count += 1
    return count


_DISCOVERY_S = 1.0
_LAST_MESSAGES_S = 2.0


def main(argv: list[str] | None = None) -> int:
    """Play; return the exit status."""
    parser = argparse.ArgumentParser(prog='player', description=__doc__)
    parser.add_argument('bag', type=Path, metavar='BAG', help='folder or file of the bag')
    PlayerOptions.add_to(parser)
    return node_main(parser, _play_bag, argv)


def _play_bag(process: RosProcess, args: argparse.Namespace) -> int:
    if args.bag.suffix == '.bag':
        raise SetcmasError(f"'{args.bag}' is a ROS 1 bag; only rosbag2 bags can be played")
    with open_bag(args.bag) as bag:
        return _play(process, bag, PlayerOptions.of(args))


def _play(process: RosProcess, bag: Bag, options: PlayerOptions) -> int:
    classes, notes = played_topics(bag)
    node = FleetNode(topics.PLAYER_NODE)
    process.requests = RequestWait([node])
    names = [topic.name for topic in classes]
    for line in [*bag.notices, *notes]:
        print(line, file=sys.stderr, flush=True)
    process.spin_until(lambda: False, _DISCOVERY_S)
    if reason := robots_in_use(node, names):
        raise SetcmasError(f'{reason}; stop that first, or set another ROS_DOMAIN_ID')
    publishers = {
        topic: node.create_publisher(kind, topic.name, played_qos(topic))
        for topic, kind in classes.items()
    }
    process.spin_until(lambda: False, _DISCOVERY_S)  # of subscribers, such as a recorder
    topics_text = 'topic' if len(publishers) == 1 else 'topics'
    seconds = (bag.end_ns - bag.start_ns) / 1e9
    print(f'playing {len(publishers)} {topics_text}, {seconds:.1f} s', flush=True)
    in_use = partial(robots_in_use, node, names, own=1)
    count = play(process, bag, publishers, options.rate, in_use)
    wait_until_received(publishers.values(), _LAST_MESSAGES_S)
    print(f'played {count:,} {"message" if count == 1 else "messages"}', flush=True)
    return 0


if __name__ == '__main__':
    sys.exit(main())
