"""Newest pose of each robot, shared by the nodes of a process."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from nav_msgs.msg import Odometry

from setcmas_simu.arrays import Floats
from setcmas_simu.ros import qos
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.messages import RobotState, state_in

POSE_TIMEOUT_S = 1.0
"""Age in s after which a robot's own pose is too old to command it."""


class FleetPoses:
    """The newest poses of robots 1 to N, from one subscription to the odometry of each.

    Attributes:
        poses: Rows x, y in m and theta in rad, shape (3, N); NaN for robots not seen yet.
        now: Time in s of the last `take`.
        new: States that it found, by robot.
        odometry: The newest usable odometry of each robot, serialised.
    """

    def __init__(self, sources: Mapping[int, tuple[FleetNode, str]], nb_robots: int) -> None:
        """Subscribe to the odometry of robots: their sources are a node and a topic for it."""
        self.poses: Floats = np.full((3, nb_robots), np.nan)
        self.now = 0.0
        self.new: dict[int, RobotState] = {}
        self.odometry: dict[int, bytes] = {}
        self._received = np.full(nb_robots, -np.inf)
        self._faults: dict[int, str] = {}
        self._sources = sources
        self._newest = {
            robot: node.newest(Odometry, topic, qos.NEWEST_STATE, raw=True)
            for robot, (node, topic) in sources.items()
        }

    def topic_of(self, robot: int) -> str:
        """Return the full name of the topic with a robot's odometry."""
        node, topic = self._sources[robot]
        name: str = node.resolve_topic_name(node.full_name(topic))
        return name

    def take(self, now: float) -> None:
        """Take the newest pose of each robot; `now` is the time of a steady clock in s."""
        self.now, self.new = now, {}
        for robot, newest in self._newest.items():
            if odometry := newest():
                self._take(robot, odometry)

    def missing(self) -> list[int]:
        """Return the followed robots without a pose yet."""
        return [robot for robot in self._newest if np.isinf(self._received[robot - 1])]

    def fault(self, robot: int) -> str:
        """Return why a robot's last odometry cannot be used; '' if it can, or none came."""
        return self._faults.get(robot, '')

    def pose(self, robot: int) -> Floats:
        """Return a copy of a robot's pose, shape (3, 1)."""
        pose: Floats = self.poses[:, robot - 1 : robot].copy()
        return pose

    def age(self, robot: int) -> float:
        """Return the age in s of a robot's pose at the last `take`."""
        return self.now - float(self._received[robot - 1])

    def _take(self, robot: int, odometry: bytes) -> None:
        state = state_in(odometry)
        if isinstance(state, str):
            self._faults[robot] = state
            return
        self._faults.pop(robot, None)
        self.poses[:, robot - 1] = state.pose
        self._received[robot - 1] = self.now
        self.new[robot] = state
        self.odometry[robot] = odometry
