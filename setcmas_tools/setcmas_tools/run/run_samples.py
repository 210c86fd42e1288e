"""Tables of a run, collected from the messages of a bag."""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from setcmas_ctrl.communication.graph import GraphChanges, complete, with_known_rows
from setcmas_ctrl.communication.message_content import Content, decoded
from setcmas_ctrl.laws.drawing import Sphere
from setcmas_ctrl.laws.references import References, not_understood
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.planar_pose import yaw_of_quaternion
from setcmas_tools.run.fleet_motion import FleetTable, check_extent, fleet_table
from setcmas_tools.run.run_records import (
    CommunicationRecord,
    Counts,
    DrawingRecord,
    SafetyRecord,
    SentMessage,
    commands,
    record_of,
    with_allowed,
)
from setcmas_tools.run.run_tables import RunTables

if TYPE_CHECKING:
    from setcmas_tools.bags.bag_reader import BagTopic, Taker

_ODOMETRY = 'nav_msgs/msg/Odometry'


def _odometry_topics(bag_topics: Iterable[BagTopic]) -> set[str]:
    """Return the topics whose odometry is the motion of a robot.

    Odometry of motion capture replaces the robot's own, which drifts.
    """
    names = {topic.name for topic in bag_topics if topic.msgtype == _ODOMETRY}
    chosen: set[str] = set()
    for robot in filter(None, map(topics.robot_of, names)):
        places = (topics.mocap_topic(robot), topics.odometry_topic(robot))
        chosen.update([place for place in places if place in names][:1])
    return chosen


def _unusable_poses(table: FleetTable) -> Iterator[str]:
    """Yield a line for each robot with poses that are NaN, infinite or without a heading."""
    unusable = ~np.isfinite(table.x + table.y + table.theta)
    for robot in np.unique(table.robot[unusable]):
        own = table.robot == robot
        yield (
            f'robot {robot}: {np.count_nonzero(unusable & own)} of {np.count_nonzero(own)} poses '
            'cannot be used: NaN, infinite, or a zero quaternion'
        )


_LATE_S = 1.0  # if a message is recorded later, its t began at another time


_MARKER = 'visualization_msgs/msg/Marker'
_SPHERE_TYPE = 2


class RunSamples:
    """Collects the tables of a run: motion, commands, communication, drawings and safety."""

    def __init__(self, bag_topics: Sequence[BagTopic]) -> None:
        """Choose the topics among those that have messages."""
        self._odometry = _odometry_topics(bag_topics)
        self._rows = array('d')
        self._events: dict[int, list[tuple[int, int]]] = {}
        self._counts: dict[int, Floats] = {}
        self._graphs: list[tuple[int, Floats]] = []
        self._contents: list[tuple[float, int, Content]] = []
        self._commands, self._allowed = array('d'), array('d')
        self._drawings = DrawingRecord()
        self._references: References | None = None
        self.notices: list[str] = []
        self._safety: list[tuple[float, int, str, bool]] = []

    def collectors(self, bag_topic: BagTopic) -> list[Taker]:
        """Return the functions that take the messages of a topic."""
        topic, msgtype = bag_topic.name, bag_topic.msgtype
        robot = topics.robot_of(topic) or 0
        name = topic.removeprefix(topics.robot_topic(robot, ''))
        takers: dict[tuple[str, str], Taker] = {
            (topics.TASK, 'std_msgs/msg/String'): self._take_task,
            (topics.DIAGNOSTICS, 'diagnostic_msgs/msg/DiagnosticArray'): self._take_statuses,
            (topics.COMMUNICATION_GRAPH, 'std_msgs/msg/Float32MultiArray'): self._take_graph,
            (topics.TRIG_EVENT, 'std_msgs/msg/UInt16'): partial(self._take_event, robot),
            (topics.LINKS, 'std_msgs/msg/Float64MultiArray'): partial(self._take_counts, robot),
            (topics.MESSAGE, 'std_msgs/msg/String'): partial(self._take_message, robot),
            (topics.CMD_CART_VEL, 'geometry_msgs/msg/Point32'): (
                lambda ns, sent: self._commands.extend((ns / 1e9, robot, sent.x, sent.y))
            ),
            (topics.CMD_CART_VEL_ALLOWED, 'geometry_msgs/msg/Point32'): (
                lambda ns, sent: self._allowed.extend((ns / 1e9, robot, sent.x, sent.y, sent.z))
            ),
        }
        found = [takers.get((name, msgtype))]
        if topic in self._odometry:
            found.append(partial(self._take_odometry, robot))
        if robot and name != topics.MARKER and msgtype.removesuffix('Array') == _MARKER:
            found.append(partial(self._take_markers, robot, name))
        return [collect for collect in found if collect]

    def tables(self) -> RunTables | None:
        """Return the tables; None if the bag has no odometry of robots."""
        if not self._rows:
            return None
        fleet = fleet_table(np.array(self._rows).reshape(-1, 7))
        self.notices += _unusable_poses(fleet)
        rows = with_allowed(
            np.array(self._commands).reshape(-1, 4), np.array(self._allowed).reshape(-1, 5)
        )
        return RunTables(
            fleet,
            commands(*rows.T) if len(rows) else None,
            self._record(fleet),
            self._drawings.drawings(),
            self._references,
            SafetyRecord.in_order(*zip(*self._safety, strict=True)) if self._safety else None,
            self._messages(),
        )

    def _take_odometry(self, robot: int, time_ns: int, message: Any) -> None:
        position, q = message.pose.pose.position, message.pose.pose.orientation
        twist = message.twist.twist
        theta = yaw_of_quaternion(q.x, q.y, q.z, q.w)
        if not (q.x or q.y or q.z or q.w):  # a zero quaternion has no heading
            theta = math.nan
        row = (time_ns / 1e9, robot, position.x, position.y, theta)
        self._rows.extend((*row, twist.linear.x, twist.angular.z))

    def _take_task(self, _: int, message: Any) -> None:
        try:
            self._references = References.decoded(message.data)
        except ValueError as error:  # of another program
            if (line := not_understood(error)) not in self.notices:
                self.notices.append(line)

    def _take_statuses(self, time_ns: int, message: Any) -> None:
        for status in message.status:
            robot = topics.robot_of(f'/{status.name}/')
            state = next((pair.value for pair in status.values if pair.key == 'state'), '')
            if robot and state:
                self._safety.append((time_ns / 1e9, robot, state, bool(status.message)))

    def _take_markers(self, robot: int, name: str, time_ns: int, message: Any) -> None:
        is_trail = hasattr(message, 'markers')
        draw = self._drawings.extend_trail if is_trail else self._drawings.show
        self._drawings.t = time_ns / 1e9
        for marker in message.markers if is_trail else [message]:
            if marker.type == _SPHERE_TYPE:
                at, colour = marker.pose.position, marker.color
                rgb = (colour.r, colour.g, colour.b)
                draw(robot, name, Sphere(at.x, at.y, at.z, marker.scale.x, rgb, colour.a))

    def _take_event(self, robot: int, time_ns: int, message: Any) -> None:
        self._events.setdefault(robot, []).append((time_ns, int(message.data)))

    def _take_graph(self, time_ns: int, message: Any) -> None:
        size = int(len(message.data) ** 0.5)
        weights = np.array(message.data[: size * size], dtype=float).reshape(size, size)
        self._graphs.append((time_ns, weights))

    def _take_counts(self, receiver: int, _: int, message: Any) -> None:
        data = np.asarray(message.data, dtype=float)
        self._counts[receiver] = data[: len(data) // 4 * 4].reshape(-1, 4)

    def _take_message(self, robot: int, time_ns: int, message: Any) -> None:
        with suppress(TypeError, ValueError):  # of other programs
            self._contents.append((time_ns / 1e9, robot, decoded(message.data)))

    def _messages(self) -> list[SentMessage]:
        """Return the values that laws sent, at the times of their calls: one for each call."""
        found: dict[tuple[float, int], SentMessage] = {}
        for received, robot, content in self._contents:
            # Prefer t: a topic's first messages are recorded late, once the recorder has found it.
            # But t stands still in pauses, and restarts with new laws.
            t = content.t if received - content.t < _LATE_S else received
            found[round(t, 6), robot] = SentMessage(t, robot, content.value)
        return [found[key] for key in sorted(found)]

    def _record(self, table: FleetTable) -> CommunicationRecord | None:
        """Return the record of the run; None if the bag holds no communication."""
        if not (self._events or self._counts or self._graphs):
            return None
        changes = self._changes()
        was_up = {(receiver, sender) for _, receiver, sender, _ in changes.rows}
        links = {
            (receiver, sender): Counts(int(row[0]), int(row[1]), int(row[2]), float(row[3]))
            for receiver, rows in self._counts.items()
            for sender, row in enumerate(rows, start=1)
            if row[0] > 0 or (receiver, sender) in was_up
        }
        triggers = [
            # The first evaluation always triggers; the recorder may have missed that message.
            (time_ns / 1e9, robot, sent if i else 1)
            for robot, events in self._events.items()
            for i, (time_ns, sent) in enumerate(events)
        ]
        periodic = {i: table.of(i).t[table.of(i).t >= 0] for i in table.robots}
        return record_of(links, triggers, changes.rows, periodic)

    def _changes(self) -> GraphChanges:
        nb_robots = max(map(len, self._counts.values()), default=0)
        graphs = self._graphs or [(0, complete(nb_robots))]
        changes = GraphChanges(len(graphs[0][1]))
        adjacency = np.zeros_like(graphs[0][1])
        for time_ns, weights in graphs:
            if weights.shape == adjacency.shape:
                adjacency = with_known_rows(weights, adjacency)
                # A graph that is sent with the first command is that of the start.
                changes.note(max(0.0, time_ns / 1e9), adjacency)
        return changes


def read_bag(path: Path, warn: Callable[[str], None]) -> RunTables:
    """Return the tables of a bag; `warn` prints losses.

    Raises:
        SetcmasError: The bag cannot be read, or holds no odometry of robots.
    """
    from setcmas_tools.bags.bag_reader import open_bag  # CSV files are read without rosbags

    with open_bag(path) as bag:
        samples = RunSamples(bag.topics)
        takers = {topic: samples.collectors(topic) for topic in bag.topics}
        bag.deliver(takers)
        tables = samples.tables()
        for notice in [*bag.notices, *samples.notices]:
            warn(notice)
    if tables:
        check_extent(tables.table, path)
        return tables
    raise SetcmasError(f"bag '{path}' holds no odometry of robots (/tb3_i/odom, {_ODOMETRY})")
