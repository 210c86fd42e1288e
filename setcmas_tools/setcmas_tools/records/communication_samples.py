"""Samples of communication among the messages of a bag."""

from __future__ import annotations

from typing import Any

import numpy as np

from setcmas_ctrl.communication.graph import GraphChanges, complete, with_known_rows
from setcmas_simu.arrays import Floats
from setcmas_simu.fleet import topics
from setcmas_tools.records.communication import CommunicationRecord, Counts, record_of
from setcmas_tools.records.fleet_samples import Collect
from setcmas_tools.records.fleet_table import FleetTable

_MATRIX = 'std_msgs/msg/Float32MultiArray'
_TABLE = 'std_msgs/msg/Float64MultiArray'
_EVENT = 'std_msgs/msg/UInt16'
_NB_COUNTS = 4


class CommunicationSamples:
    """Collects triggers, graphs, and the counts of links."""

    def __init__(self) -> None:
        """Start without any message."""
        self._events: dict[int, list[tuple[int, int]]] = {}
        self._counts: dict[int, Floats] = {}
        self._graphs: list[tuple[int, Floats]] = []

    def collector(self, topic: str, msgtype: str) -> Collect | None:
        """Return the function that takes the messages of a topic; None if it is not of use."""
        if topic == topics.COMMUNICATION_GRAPH and msgtype == _MATRIX:
            return self._take_graph
        robot = topics.robot_of(topic)
        if robot and topic == topics.robot_topic(robot, topics.TRIG_EVENT) and msgtype == _EVENT:
            events = self._events.setdefault(robot, [])
            return lambda time_ns, message: events.append((time_ns, int(message.data)))
        if robot and topic == topics.robot_topic(robot, topics.LINKS) and msgtype == _TABLE:
            return lambda _, message: self._take_counts(robot, message)
        return None

    def record(self, table: FleetTable | None, start_ns: int) -> CommunicationRecord | None:
        """Return the record of the run; None if the robots did not communicate as it tells.

        Args:
            table: The fleet's motion.
            start_ns: Time that is t = 0, in ns from the bag's start.
        """
        if not (self._events or self._counts or self._graphs):
            return None
        changes = self._changes(start_ns)
        was_up = {(receiver, sender) for _, receiver, sender, _ in changes.rows}
        links = {
            (receiver, sender): Counts(int(row[0]), int(row[1]), int(row[2]), float(row[3]))
            for receiver, rows in self._counts.items()
            for sender, row in enumerate(rows, start=1)
            if row[0] > 0 or (receiver, sender) in was_up
        }
        triggers = [
            ((time_ns - start_ns) / 1e9, robot, sent)
            for robot, events in self._events.items()
            for time_ns, sent in _with_first_state(events)
        ]
        periodic = {i: table.of(i).t[table.of(i).t >= 0] for i in table.robots} if table else {}
        return record_of(links, triggers, changes.rows, periodic)

    def _changes(self, start_ns: int) -> GraphChanges:
        nb_robots = max([len(rows) for rows in self._counts.values()], default=0)
        graphs = self._graphs or [(start_ns, complete(nb_robots))]
        changes = GraphChanges(len(graphs[0][1]))
        adjacency = np.zeros_like(graphs[0][1])
        for time_ns, weights in graphs:
            if weights.shape == adjacency.shape:
                adjacency = with_known_rows(weights, adjacency)
                # A graph that is sent with the first command is that of the start.
                changes.note(max(0.0, (time_ns - start_ns) / 1e9), adjacency)
        return changes

    def _take_graph(self, time_ns: int, message: Any) -> None:
        self._graphs.append((time_ns, _square(message.data)))

    def _take_counts(self, receiver: int, message: Any) -> None:
        data = np.asarray(message.data, dtype=float)
        self._counts[receiver] = data[: len(data) // _NB_COUNTS * _NB_COUNTS].reshape(
            -1, _NB_COUNTS
        )


def _square(data: Any) -> Floats:
    size = int(len(data) ** 0.5)
    return np.array(data[: size * size], dtype=float).reshape(size, size)


def _with_first_state(events: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return events of which the first tells that the state was sent, as the first always is.

    It is told so where the robot sent it before the recorder listened.
    """
    return [(events[0][0], 1), *events[1:]] if events else []
