"""Recorder process: records topics into a rosbag2 bag until a signal asks it to stop."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from rosbags.interfaces import (
    Connection,
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.typesys import Stores, get_typestore

from setcmas_simu.fleet import topics
from setcmas_simu.reports import WRITES_S, Recording
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.fleet_topic import FleetListener
from setcmas_simu.ros.messages import NoPythonTypeError, message_class
from setcmas_simu.ros.polling import RequestWait
from setcmas_simu.ros.process import RosProcess, end_process, node_main
from setcmas_tools.bags.bag_writer import BagWriter, UnknownDefinitionError, add_definition
from setcmas_tools.bags.recording_options import RecorderOptions


class GraphRecorder:
    """Subscribes to each topic and writes its messages to a bag.

    `drain` raises OSError if the disk is full or fails.
    """

    def __init__(
        self, node: Node, writer: BagWriter, chosen: list[str] | None = None, rtf: float = 1.0
    ) -> None:
        """Start without any topic.

        Args:
            node: A node, which sees the graph.
            writer: The bag.
            chosen: Full names of the topics to record; None for all.
            rtf: Seconds of the robots per second.
        """
        self._node = node
        self._requests = RequestWait([node])
        self._writer = writer
        self._chosen = chosen
        self._rtf, self._times = rtf, ArrivalTimes(rtf)
        self._waiting: list[Received] = []
        self._types = get_typestore(Stores.ROS2_JAZZY)
        self._topics: dict[str, RecordedTopic] = {}
        # Of each topic at the last look: number of publishers, types.
        self._seen: dict[str, tuple[int, list[str]]] = {}
        self._printed: set[str] = set()
        self._fleet = FleetListener(node)

    @property
    def recorded(self) -> list[str]:
        """Names of the topics that had a publisher."""
        return [*self._topics]

    def look(self) -> None:
        """Follow changes of the graph since the last look, and answer requests."""
        self._fleet.take()
        rtf = self._fleet.first.rtf
        if self._fleet.robots and rtf != self._rtf:
            self._print_once(
                f'times in the bag are wrong: the simulator has --rtf {rtf:g}; stop, '
                'and record with the same option'
            )
        self._requests.wait(0.0)
        for name, types in self._node.get_topic_names_and_types():
            if self._is_wanted(name):
                state = (self._node.count_publishers(name), types)
                if state != self._seen.get(name):
                    self._seen[name] = state
                    self._follow(name)

    def missing(self) -> list[int]:
        """Return the announced robots without any topic so far."""
        self._fleet.take()
        if self._chosen is not None:
            return []
        seen = {topics.robot_of(name) for name in self.recorded}
        return [robot for robot in self._fleet.robots if robot not in seen]

    def drain(self) -> None:
        """Write the messages received so far, in order."""
        self._waiting += [message for topic in self._topics.values() for message in topic.take()]
        for stamp, message in self._times.of(self._waiting):
            self._writer.write(message.connection, stamp, message.data)

    def _is_wanted(self, name: str) -> bool:
        if self._chosen is not None:
            return name in self._chosen
        return '/_' not in name

    def _follow(self, name: str) -> None:
        infos = self._node.get_publishers_info_by_topic(name)
        if not infos:
            return
        topic, offered = self._topics.get(name), [info.topic_type for info in infos]
        msgtype = topic.msgtype if topic and topic.msgtype in offered else offered[0]
        profiles = [info.qos_profile for info in infos if info.topic_type == msgtype]
        if topic is None or topic.msgtype != msgtype:
            topic = self._subscribe(name, msgtype, profiles)
        for other in {*offered} - {msgtype}:
            self._print_once(f'{name} has a second type {other}: only {msgtype} is recorded')
        if topic:
            self._waiting += topic.adapt_to(profiles)

    def _subscribe(
        self, name: str, msgtype: str, profiles: list[QoSProfile]
    ) -> RecordedTopic | None:
        if previous := self._topics.pop(name, None):
            self._waiting += previous.end()
        try:
            add_definition(msgtype, self._types)
            message_type = message_class(msgtype)
        except (NoPythonTypeError, UnknownDefinitionError) as error:
            self._print_once(f'{name} ({msgtype}) is not recorded: {error}')
            return None
        connection = self._writer.add_topic(name, msgtype, self._types, stored_qos(profiles))
        self._topics[name] = RecordedTopic(self._node, connection, message_type)
        return self._topics[name]

    def _print_once(self, line: str) -> None:
        if line not in self._printed:
            self._printed.add(line)
            print(line, file=sys.stderr, flush=True)


DEPTH = 1000
"""Messages of a topic that may wait: a second of the fastest motion capture."""


def stored_qos(profiles: list[QoSProfile]) -> list[Qos]:
    """Return the different profiles of a topic's publishers in the terms of rosbags."""
    stored = [
        Qos(
            QosHistory[profile.history.name],
            profile.depth,
            QosReliability[profile.reliability.name],
            QosDurability[profile.durability.name],
            _time(profile.deadline),
            _time(profile.lifespan),
            QosLiveliness[profile.liveliness.name],
            _time(profile.liveliness_lease_duration),
            profile.avoid_ros_namespace_conventions,
        )
        for profile in profiles
    ]
    return list(dict.fromkeys(stored))


def _time(duration: Duration) -> QosTime:
    return QosTime(*divmod(duration.nanoseconds, 10**9))


_RELIABLE = ReliabilityPolicy.RELIABLE
_TRANSIENT_LOCAL = DurabilityPolicy.TRANSIENT_LOCAL


@dataclass
class Received:
    """A received message.

    Attributes:
        time_ns: Time of arrival on the system's clock.
        connection: Its topic in the bag.
    """

    time_ns: int
    connection: Connection
    data: bytes


class RecordedTopic:
    """Takes the serialised messages of a topic without an executor.

    An executor would wake up for each message and rebuild its wait set over all topics; asking
    each topic for its messages 20 times a second costs a third of that.

    Attributes:
        msgtype: Type of its messages.
    """

    def __init__(self, node: Node, connection: Connection, message_type: type) -> None:
        """Prepare for a topic of the bag; `adapt_to` subscribes."""
        self.msgtype = connection.msgtype
        self._node, self._connection, self._message_type = node, connection, message_type
        self._guarantees = (True, True)  # reliable, transient local
        self._subscription: Subscription | None = None

    def adapt_to(self, profiles: list[QoSProfile]) -> list[Received]:
        """Subscribe so that as little is lost as publishers allow; return what came before."""
        # Never up again: latched messages would arrive twice.
        reliable, latched = self._guarantees
        reliable = reliable and all(one.reliability == _RELIABLE for one in profiles)
        latched = latched and all(one.durability == _TRANSIENT_LOCAL for one in profiles)
        if self._subscription and (reliable, latched) == self._guarantees:
            return []
        received = self.end()
        self._guarantees = reliable, latched
        profile = QoSProfile(
            depth=DEPTH,
            reliability=_RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
            durability=_TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        )
        self._subscription = self._node.create_subscription(
            self._message_type, self._connection.topic, lambda _: None, profile, raw=True
        )
        return received

    def take(self) -> Iterator[Received]:
        """Yield the messages received since the last call."""
        if self._subscription is None:
            return
        handle = self._subscription.handle
        with handle:
            for _ in range(DEPTH):
                taken = handle.take_message(self._message_type, True)
                if taken is None:
                    return
                data, info = taken
                yield Received(info['received_timestamp'], self._connection, data)

    def end(self) -> list[Received]:
        """Unsubscribe; return the last messages."""
        received = list(self.take())
        if self._subscription:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None
        return received


class ArrivalTimes:
    """Times of arrival in the time of the robots.

    They start on the system's clock, but do not follow when it is set during a recording:
    a jump of an hour would otherwise freeze or stretch the recorded run.
    """

    def __init__(self, rtf: float = 1.0) -> None:
        """Start now; `rtf` is the number of seconds of the robots per second."""
        self._rtf = rtf
        self._begin, self._steady_begin = time.time_ns(), time.monotonic_ns()
        self._last = 0

    def of(self, messages: list[Received]) -> Iterator[tuple[int, Received]]:
        """Yield messages with their times in ns, in order, and take them from the list."""
        now, elapsed = time.time_ns(), time.monotonic_ns() - self._steady_begin
        messages.sort(key=lambda message: message.time_ns)
        for message in messages:
            age = now - (message.time_ns or now)  # 0 is unknown
            self._last = max(self._last, elapsed - age)
            yield self._begin + round(self._last * self._rtf), message
        messages.clear()


_TAKE_PERIOD_S = 0.05
_LOOK_PERIOD_S = 0.2
_FLUSH_PERIOD_S = 1.0


def main(argv: list[str] | None = None) -> int:
    """Record; return the exit status."""
    parser = argparse.ArgumentParser(
        prog='recorder',
        description='Record all topics of this namespace but hidden ones (/_...) into a rosbag2 '
        'bag, new topics as they appear, until Ctrl-C.',
    )
    RecorderOptions.add_to(parser)
    return node_main(parser, _record_bag, argv)


def _record_bag(process: RosProcess, args: argparse.Namespace) -> int:
    process.longest_end_s = int(WRITES_S)
    options = RecorderOptions.of(args)
    node = FleetNode(topics.RECORDER_NODE)
    chosen = [node.name_in_fleet(name) for name in options.topics or ()] or None
    try:
        with BagWriter(options.output) as writer:
            recorder = GraphRecorder(node, writer, chosen, options.rtf)
            _record(process, recorder, writer)
    except OSError as error:
        reason = f'{error.strerror}; earlier messages are readable'
        print(f"error: recording to '{options.output}' stopped: {reason}", file=sys.stderr)
        return 1
    for name in sorted(set(chosen or []) - set(recorder.recorded)):
        print(f'{name} was never published', file=sys.stderr)
    if writer.count:
        print(f'recorded {writer} to {writer.path}', flush=True)
    else:
        print(
            f'nothing was recorded: no message arrived; {writer.path} is an empty bag', flush=True
        )
    return 0


def _record(process: RosProcess, recorder: GraphRecorder, writer: BagWriter) -> None:
    next_look = next_flush = 0.0
    reported = False
    nb_topics = 0
    while not process.stopping:
        now = time.monotonic()
        if now >= next_look:
            next_look = now + _LOOK_PERIOD_S
            recorder.look()
            # Topics of a node appear one after another: wait for a look without new ones.
            complete = 0 < nb_topics == len(recorder.recorded) and not recorder.missing()
            if not reported and complete:
                reported = True
                topics_text = 'topic' if nb_topics == 1 else 'topics'
                print(f'recording {nb_topics} {topics_text} to {writer.path}', flush=True)
                process.launcher.report(Recording(nb_topics))
            nb_topics = len(recorder.recorded)
        recorder.drain()
        if now >= next_flush:
            next_flush = now + _FLUSH_PERIOD_S
            writer.flush()
        time.sleep(_TAKE_PERIOD_S)
    recorder.drain()


if __name__ == '__main__':
    end_process(main())
