"""Tables of a run among the messages of a bag."""

from __future__ import annotations

from array import array
from collections.abc import Iterable
from functools import partial
from typing import Any

import numpy as np

from setcmas_ctrl.control.references import References
from setcmas_ctrl.drawing import Sphere
from setcmas_simu.fleet import topics
from setcmas_tools.records.commands import commands, with_allowed
from setcmas_tools.records.communication_samples import CommunicationSamples
from setcmas_tools.records.drawings import DrawingRecord
from setcmas_tools.records.fleet_samples import Collect, FleetSamples
from setcmas_tools.records.safety import Row, SafetyRecord, safety_record
from setcmas_tools.records.tables import RunTables

_VELOCITY = 'geometry_msgs/msg/Point32'
_MARKER = 'visualization_msgs/msg/Marker'
_TRAIL = 'visualization_msgs/msg/MarkerArray'
_TEXT = 'std_msgs/msg/String'
_STATUSES = 'diagnostic_msgs/msg/DiagnosticArray'
_SPHERE_TYPE = 2


class RunSamples:
    """Collects what makes the tables of a run: motion, commands, communication, and so on."""

    def __init__(self, bag_topics: Iterable[tuple[str, str]]) -> None:
        """Choose the topics.

        Args:
            bag_topics: Names and types of the topics that have messages.
        """
        self._fleet = FleetSamples(bag_topics)
        self._communication = CommunicationSamples()
        self._commands = array('d')
        self._allowed = array('d')
        self._drawings = DrawingRecord()
        self._references: References | None = None
        self._safety: list[Row] = []

    def collectors(self, topic: str, msgtype: str) -> list[Collect]:
        """Return the functions that take the messages of a topic; none if it is not of use."""
        found = [
            self._fleet.collector(topic),
            self._communication.collector(topic, msgtype),
            self._own_collector(topic, msgtype),
        ]
        return [collect for collect in found if collect]

    def tables(self) -> RunTables | None:
        """Return the tables; None if the bag has no odometry of robots."""
        fleet, start_ns = self._fleet.table(), self._fleet.start_ns
        if fleet is None:
            return None
        rows = with_allowed(
            np.array(self._commands).reshape(-1, 4), np.array(self._allowed).reshape(-1, 5)
        )
        rows[:, 0] -= start_ns / 1e9
        return RunTables(
            fleet,
            commands(rows) if len(rows) else None,
            self._communication.record(fleet, start_ns),
            self._drawings.drawings(start_ns / 1e9),
            self._references,
            self._safety_record(start_ns / 1e9),
        )

    def _safety_record(self, start: float) -> SafetyRecord | None:
        rows = [(t - start, robot, state, over) for t, robot, state, over in self._safety]
        return safety_record(rows) if rows else None

    def _own_collector(self, topic: str, msgtype: str) -> Collect | None:
        if topic == topics.TASK and msgtype == _TEXT:
            return self._take_task
        if topic == topics.DIAGNOSTICS and msgtype == _STATUSES:
            return self._take_statuses
        robot = topics.robot_of(topic)
        if not robot:
            return None
        name = topic.removeprefix(topics.robot_topic(robot, ''))
        if name == topics.CMD_CART_VEL and msgtype == _VELOCITY:
            return partial(self._take_command, robot)
        if name == topics.CMD_CART_VEL_ALLOWED and msgtype == _VELOCITY:
            return partial(self._take_allowed, robot)
        if name != topics.MARKER and msgtype == _MARKER:
            return partial(self._take_marker, robot, name)
        if msgtype == _TRAIL:
            return partial(self._take_trail, robot, name)
        return None

    def _take_task(self, _: int, message: Any) -> None:
        try:
            self._references = References.decoded(message.data)
        except ValueError:
            return  # of somebody else

    def _take_statuses(self, time_ns: int, message: Any) -> None:
        for status in message.status:
            robot = topics.robot_of(f'/{status.name}/')
            state = next((pair.value for pair in status.values if pair.key == 'state'), '')
            if robot and state:
                self._safety.append((time_ns / 1e9, robot, state, bool(status.message)))

    def _take_command(self, robot: int, time_ns: int, message: Any) -> None:
        self._commands.extend((time_ns / 1e9, robot, message.x, message.y))

    def _take_allowed(self, robot: int, time_ns: int, message: Any) -> None:
        self._allowed.extend((time_ns / 1e9, robot, message.x, message.y, message.z))

    def _take_marker(self, robot: int, name: str, time_ns: int, message: Any) -> None:
        if message.type == _SPHERE_TYPE:
            self._drawings.t = time_ns / 1e9
            self._drawings.show(robot, name, _sphere(message))

    def _take_trail(self, robot: int, name: str, time_ns: int, message: Any) -> None:
        self._drawings.t = time_ns / 1e9
        for marker in message.markers:
            if marker.type == _SPHERE_TYPE:
                self._drawings.extend_trail(robot, name, _sphere(marker))


def _sphere(marker: Any) -> Sphere:
    position, colour = marker.pose.position, marker.color
    rgb = (colour.r, colour.g, colour.b)
    return Sphere(position.x, position.y, position.z, marker.scale.x, rgb, colour.a)
