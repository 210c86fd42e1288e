"""The fleet's odometry among the messages of a bag."""

from __future__ import annotations

import re
from array import array
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from setcmas_simu.fleet import topics
from setcmas_simu.fleet.planar_pose import yaw_of_quaternion
from setcmas_tools.records.fleet_table import FleetTable, fleet_table

_ODOMETRY = 'nav_msgs/msg/Odometry'
_MOTION_CAPTURE = '/mocap'
_NB_NUMBERS = 10  # t, robot, x, y, a quaternion, v, omega

Collect = Callable[[int, Any], None]
"""Takes the time of a message in ns from the bag's start, and the message."""


class FleetSamples:
    """Collects what makes fleet.csv: odometry of each robot and the time of the first command.

    Odometry of motion capture goes before the robot's own, which drifts.
    """

    def __init__(self, bag_topics: Iterable[tuple[str, str]]) -> None:
        """Choose the topics.

        Args:
            bag_topics: Names and types of the topics that have messages.
        """
        self._rows = array('d')
        self._first_command_ns: int | None = None
        self._first_go_ns: int | None = None
        self._odometry: dict[int, str] = {}
        named = sorted(bag_topics)
        # A recording of what `setcmas play` plays has no commands but what the laws returned.
        commanded = any(_robot_of(name, topics.CMD_VEL) for name, _ in named)
        self._command = topics.CMD_VEL if commanded else topics.CMD_CART_VEL
        for name, msgtype in named:
            robot = _robot_of(name, topics.ODOM)
            if robot and msgtype == _ODOMETRY and self._odometry.get(robot, '/tb3') >= '/tb3':
                self._odometry[robot] = name

    def collector(self, topic: str) -> Collect | None:
        """Return the function that takes the messages of a topic; None if it is not of use."""
        if topic == topics.PAUSED:
            return self._take_pause
        if _robot_of(topic, self._command):
            return self._take_command
        robot = _robot_of(topic, topics.ODOM)
        if robot and self._odometry.get(robot) == topic:
            return lambda time_ns, message: self._take_odometry(robot, time_ns, message)
        return None

    @property
    def start_ns(self) -> int:
        """What is t = 0 in ns from the bag's start: the first command, else the first odometry.

        In an experiment, where zeros are sent from the beginning, it is when it is started.
        """
        if self._first_go_ns is not None:
            return self._first_go_ns
        if self._first_command_ns is not None:
            return self._first_command_ns
        return round(min(self._rows[::_NB_NUMBERS], default=0.0) * 1e9)

    def table(self) -> FleetTable | None:
        """Return the table."""
        if not self._rows:
            return None
        rows = np.array(self._rows).reshape(-1, _NB_NUMBERS)
        rows[:, 0] -= self.start_ns / 1e9
        x, y, z, w, *_ = rows[:, 4:].T
        theta = yaw_of_quaternion(x, y, z, w)
        return fleet_table(np.column_stack([rows[:, :4], theta, rows[:, 8:]]))

    def _take_command(self, time_ns: int, _: Any) -> None:
        if self._first_command_ns is None or time_ns < self._first_command_ns:
            self._first_command_ns = time_ns

    def _take_pause(self, time_ns: int, message: Any) -> None:
        if not message.data and (self._first_go_ns is None or time_ns < self._first_go_ns):
            self._first_go_ns = time_ns

    def _take_odometry(self, robot: int, time_ns: int, message: Any) -> None:
        position, q = message.pose.pose.position, message.pose.pose.orientation
        twist = message.twist.twist
        row = (time_ns / 1e9, robot, position.x, position.y, q.x, q.y, q.z, q.w)
        self._rows.extend((*row, twist.linear.x, twist.angular.z))


def _robot_of(name: str, topic: str) -> int | None:
    found = re.fullmatch(rf'(?:{_MOTION_CAPTURE})?/tb3_([1-9][0-9]*)/{topic}', name)
    return int(found[1]) if found else None
