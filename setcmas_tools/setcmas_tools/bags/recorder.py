"""Recorder process: records topics into a rosbag2 bag until a signal asks it to stop."""

from __future__ import annotations

import argparse
import sys
import time

from rclpy.node import Node

from setcmas_simu.fleet import topics
from setcmas_simu.reports import WRITES_S, Recording
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.fleet_topic import FleetListener
from setcmas_simu.ros.message_class import NoPythonTypeError
from setcmas_simu.ros.polling import PolledServices
from setcmas_simu.ros.process import RosProcess, end_process, node_main
from setcmas_tools.bags.bag_writer import BagWriter
from setcmas_tools.bags.message_types import MessageDefinitions, UnknownDefinitionError
from setcmas_tools.bags.recorded_topic import (
    ArrivalTimes,
    Received,
    RecordedTopic,
    stored_qos,
)
from setcmas_tools.bags.recording_options import RecorderOptions

_TAKE_PERIOD_S = 0.05


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
        if self._fleet.robots and self._fleet.rtf != self._rtf:
            self._print_once(
                f'times in the bag are wrong: the simulator has --rtf {self._fleet.rtf:g}; stop, '
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
            definition = self._definitions.of(topic.msgtype)
            topic.connection = self._writer.add_topic(
                name, topic.msgtype, definition, stored_qos(profiles)
            )
        self._waiting += topic.adapt_to(profiles)

    def _subscribe(self, name: str, msgtype: str) -> RecordedTopic | None:
        previous = self._topics.pop(name, None)
        if previous:
            self._waiting += previous.take()
            previous.close()
        try:
            self._definitions.of(msgtype)
            self._topics[name] = RecordedTopic(self._node, name, msgtype)
        except (NoPythonTypeError, UnknownDefinitionError) as error:
            self._print_once(f'{name} ({msgtype}) is not recorded: {error}')
        return self._topics.get(name)

    def _print_once(self, line: str) -> None:
        if line not in self._printed:
            self._printed.add(line)
            print(line, file=sys.stderr, flush=True)


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
