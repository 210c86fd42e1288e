"""Newest pose of each robot of a fleet, from one subscription per robot."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import NamedTuple

import numpy as np
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import QoSProfile

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.planar_pose import yaw_of_quaternion
from setcmas_simu.ros import qos
from setcmas_simu.ros.messages import NO_STAMP, read_odometry, read_stamp
from setcmas_simu.ros.polling import PolledTopic, suited_to

Pose = tuple[float, float, float]
"""x, y in m and theta in rad."""


class State(NamedTuple):
    """State of a robot: pose, forward speed V in m/s, and the encoded odometry."""

    pose: Pose
    V: float
    odometry: bytes


Listener = Callable[[State], None]

POSE_TIMEOUT_S = 1.0
"""Age in s after which a robot's own pose is too old to command it."""


class FleetOdometry:
    """The newest poses of robots 1 to N.

    Attributes:
        in_lockstep: Whether the states of all robots come in one array.
        poses: Rows x, y in m and theta in rad, shape (3, N); NaN for robots not seen yet.
        stamps: Times of the newest odometry in ns, shape (N,); NO_STAMP for robots not seen yet.
        now: Time in s of the last `take`.
    """

    in_lockstep = False

    def __init__(
        self,
        node: Node,
        nb_robots: int,
        topic_of: Callable[[int], str] = topics.odometry_topic,
        robots: Iterable[int] | None = None,
        profile: QoSProfile = qos.STATE,
    ) -> None:
        """Subscribe to the odometry of some robots, by default all."""
        self.topic_of = topic_of
        self.poses: Floats = np.full((3, nb_robots), np.nan)
        self.now = 0.0
        self.stamps = np.full(nb_robots, NO_STAMP)
        self._received = np.full(nb_robots, -np.inf)
        self._faults: dict[int, str] = {}
        self._followed = list(robots or range(1, nb_robots + 1))
        self._listeners: list[list[Listener]] = [[] for _ in range(nb_robots)]
        self.topics = self._subscribed(node, profile)

    def _subscribed(self, node: Node, profile: QoSProfile) -> dict[int, PolledTopic]:
        """Return the subscription to the odometry of each robot."""
        return {
            robot: PolledTopic(
                node,
                Odometry,
                self.topic_of(robot),
                partial(self._on_odometry, robot - 1),
                profile,
                encoded=True,
            )
            for robot in self._followed
        }

    def take(self, now: float) -> None:
        """Take the newest pose of each robot; `now` is the time of a steady clock in s."""
        self.now = now
        for topic in self.topics.values():
            topic.take()

    def listen(self, robot: int, listener: Listener) -> None:
        """Call a function with each new state of a robot."""
        self._listeners[robot - 1].append(listener)

    def missing(self) -> list[int]:
        """Return the followed robots without a pose yet."""
        return [robot for robot in self._followed if np.isinf(self._received[robot - 1])]

    def fault(self, robot: int) -> str:
        """Return why a robot's last odometry cannot be used; '' if it can, or none came."""
        return self._faults.get(robot - 1, '')

    def accept_best_effort(self, robots: Iterable[int]) -> None:
        """Subscribe to the odometry of these robots as it is offered, reliable or not."""
        for robot in robots:
            if robot in self.topics:
                self.topics[robot].accept_best_effort()

    def age(self, robot: int) -> float:
        """Return the age in s of a robot's pose at the last `take`."""
        return self.now - float(self._received[robot - 1])

    def _on_odometry(self, index: int, data: bytes) -> None:
        self.stamps[index] = read_stamp(data)
        state = read_state(data)
        if isinstance(state, str):
            self._faults[index] = state
            return
        self._faults.pop(index, None)
        self.poses[:, index] = state.pose
        self._received[index] = self.now
        for listener in self._listeners[index]:
            listener(state)


def offered_profile(node: Node, topic: str) -> QoSProfile:
    """Return the quality of service for newest states, best effort if a publisher is."""
    return QoSProfile(depth=1, reliability=suited_to(node, topic, 1).reliability)


def read_state(data: bytes) -> State | str:
    """Return the state in an encoded odometry, or why its pose cannot be used."""
    odometry = read_odometry(data)
    pose = (*odometry.position, yaw_of_quaternion(*odometry.quaternion))
    return odometry.fault or State(pose, odometry.V, data)
