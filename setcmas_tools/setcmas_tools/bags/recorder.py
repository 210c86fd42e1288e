"""Recorder process: records topics into a rosbag2 bag until a signal asks it to stop."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator
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

from setcmas_simu.fleet import topics
from setcmas_simu.reports import WRITES_S, Recording
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.fleet_topic import FleetListener
from setcmas_simu.ros.message_class import NoPythonTypeError, message_class
from setcmas_simu.ros.polling import PolledServices
from setcmas_simu.ros.process import RosProcess, end_process, node_main
from setcmas_tools.bags.bag_writer import BagWriter, MessageDefinitions, UnknownDefinitionError
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
        self._requests = PolledServices(node)
        self._writer = writer
        self._chosen = chosen
        self._rtf, self._times = rtf, ArrivalTimes(rtf)
        self._waiting: list[Received] = []
        self._definitions = MessageDefinitions()
        self._topics: dict[str, RecordedTopic] = {}
        # Of each topic at the last look: number of publishers, types.
        self._seen: dict[str, tuple[int, list[str]]] = {}
        self._printed: set[str] = set()
        self._fleet = FleetListener(node)

    @property
    def recorded(self) -> list[str]:
        """Names of the topics with a publisher."""
        return [topic.name for topic in self._topics.values() if topic.connection]

    def look(self) -> None:
        """Follow changes of the graph since the last look, and answer requests."""
        self._fleet.take()
        rtf = self._fleet.first.rtf
        if self._fleet.robots and rtf != self._rtf:
            self._print_once(
                f'times in the bag are wrong: the simulator has --rtf {rtf:g}; stop, '
                'and record with the same option'
            )
        self._requests.take()
        for name, types in self._node.get_topic_names_and_types():
            if self._is_wanted(name):
                state = (self._node.count_publishers(name), types)
                if state != self._seen.get(name):
                    self._seen[name] = state
                    self._follow(name, types)

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
        for message in self._waiting:
            if not message.topic.connection:
                self._follow(message.topic.name, [message.topic.msgtype])
        for stamp, message in self._times.of(self._waiting):
            if message.topic.connection:
                self._writer.write(message.topic.connection, stamp, message.data)

    def _is_wanted(self, name: str) -> bool:
        if self._chosen is not None:
            return name in self._chosen
        return '/_' not in name

    def _follow(self, name: str, types: list[str]) -> None:
        infos = self._node.get_publishers_info_by_topic(name)
        offered = list(dict.fromkeys(info.topic_type for info in infos)) or types
        topic = self._topics.get(name)
        if topic is None or topic.msgtype not in offered:
            topic = self._subscribe(name, offered[0])
        if topic is None or not infos:
            return
        for other in set(offered) - {topic.msgtype}:
            self._print_once(f'{name} has a second type {other}: only {topic.msgtype} is recorded')
        profiles = [info.qos_profile for info in infos if info.topic_type == topic.msgtype]
        if not topic.connection:
            topic.connection = self._writer.add_topic(
                name, topic.msgtype, self._definitions.store, stored_qos(profiles)
            )
        self._waiting += topic.adapt_to(profiles)

    def _subscribe(self, name: str, msgtype: str) -> RecordedTopic | None:
        previous = self._topics.pop(name, None)
        if previous:
            self._waiting += previous.take()
            previous.close()
        try:
            self._definitions.add(msgtype)
            self._topics[name] = RecordedTopic(self._node, name, msgtype)
        except (NoPythonTypeError, UnknownDefinitionError) as error:
            self._print_once(f'{name} ({msgtype}) is not recorded: {error}')
        return self._topics.get(name)

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


_TRANSIENT_LOCAL = DurabilityPolicy.TRANSIENT_LOCAL


@dataclass
class Received:
    """A received message.

    Attributes:
        time_ns: Time of arrival on the system's clock.
    """

    time_ns: int
    topic: RecordedTopic
    data: bytes


class RecordedTopic:
    """Takes the serialised messages of a topic without an executor.

    An executor would wake up for each message and rebuild its wait set over all topics; asking
    each topic for its messages 20 times a second costs a third of that.

    Attributes:
        name: Full name.
        msgtype: Type of its messages.
        connection: The topic in the bag; None until a publisher is known.
    """

    def __init__(self, node: Node, name: str, msgtype: str) -> None:
        """Subscribe, reliably; publishers may not be known yet.

        An early subscription receives the first messages of a later publisher.

        Raises:
            NoPythonTypeError: The type's Python package is missing.
        """
        self.name = name
        self.msgtype = msgtype
        self.connection: Connection | None = None
        self._node = node
        self._class = message_class(msgtype)
        self._has_publishers = False
        self._reliable, self._transient_local = True, False
        self._taken_early: set[int] = set()
        self._subscription: Subscription | None = None
        self._subscribe()

    def adapt_to(self, profiles: list[QoSProfile]) -> list[Received]:
        """Subscribe again if the profiles of publishers require it; return what came before."""
        reliable = all(one.reliability == ReliabilityPolicy.RELIABLE for one in profiles)
        transient_local = all(one.durability == _TRANSIENT_LOCAL for one in profiles)
        if self._has_publishers:
            # Never up again: latched messages would arrive twice.
            reliable &= self._reliable
            transient_local &= self._transient_local
        received = list(self.take())
        self._has_publishers = True
        if self._subscription and (reliable, transient_local) != (
            self._reliable,
            self._transient_local,
        ):
            self._reliable, self._transient_local = reliable, transient_local
            self._node.destroy_subscription(self._subscription)
            self._subscribe()
        return received

    def take(self) -> Iterator[Received]:
        """Yield the messages received since the last call."""
        if self._subscription is None:
            return
        handle = self._subscription.handle
        with handle:
            for _ in range(DEPTH):
                taken = handle.take_message(self._class, True)
                if taken is None:
                    return
                data, info = taken
                if self._is_new(info['source_timestamp']):
                    yield Received(info['received_timestamp'], self, data)

    def close(self) -> None:
        """Unsubscribe; nothing more is received."""
        if self._subscription:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None

    def _subscribe(self) -> None:
        """Subscribe so that as little is lost as the publishers allow."""
        reliability = (
            ReliabilityPolicy.RELIABLE if self._reliable else ReliabilityPolicy.BEST_EFFORT
        )
        durability = _TRANSIENT_LOCAL if self._transient_local else DurabilityPolicy.VOLATILE
        profile = QoSProfile(depth=DEPTH, reliability=reliability, durability=durability)
        self._subscription = self._node.create_subscription(
            self._class, self.name, lambda _: None, profile, raw=True
        )

    def _is_new(self, source_ns: int) -> bool:
        if self._has_publishers:
            # A latched publisher sends its messages again to the second subscription.
            return source_ns not in self._taken_early
        self._taken_early.add(source_ns)
        return True


Timed = tuple[int, Received]
"""A time in ns, and the message that has it."""


class ArrivalTimes:
    """Times of arrival in the time of the robots.

    They start on the system's clock, but do not follow when it is set during a recording:
    a jump of an hour would otherwise freeze or stretch the recorded run.
    """

    def __init__(
        self,
        rtf: float = 1.0,
        system_ns: Callable[[], int] = time.time_ns,
        steady_ns: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        """Start.

        Args:
            rtf: Seconds of the robots per second.
            system_ns: Clock of the messages, in ns; it may be set.
            steady_ns: A clock that is never set, in ns.
        """
        self._rtf = rtf
        self._system_ns = system_ns
        self._steady_ns = steady_ns
        self._begin = self._last = system_ns()
        self._offset = self._begin - steady_ns()

    def of(self, messages: list[Received]) -> Iterator[Timed]:
        """Yield messages with their times, in order, and take them from the list."""
        now = self._system_ns()
        jump = now - self._steady_ns() - self._offset
        messages.sort(key=lambda message: message.time_ns)
        for message in messages:
            arrival = (message.time_ns or now) - jump  # 0 is unknown
            self._last = max(self._last, arrival)
            yield self._begin + round((self._last - self._begin) * self._rtf), message
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
