"""What a process knows of its fleet: the newest pose of each robot, by one subscription each."""

from __future__ import annotations

import time
from functools import partial

import numpy as np
from nav_msgs.msg import Odometry
from numpy.typing import NDArray
from rclpy.node import Node

from setcmas_simu import topics
from setcmas_simu.nodes import qos
from setcmas_simu.planar_pose import yaw_of_quaternion

POSE_TIMEOUT_S = 1.0
"""Age in s from which a robot's own pose is too old to command it."""


class FleetOdometry:
    """The newest poses of robots 1 to N.

    Attributes:
        poses: Rows x, y in m and theta in rad, shape (3, N); NaN for robots not seen yet.
    """

    def __init__(self, node: Node, nb_robots: int) -> None:
        """Subscribe to the odometry of every robot of the fleet."""
        self.poses: NDArray[np.float64] = np.full((3, nb_robots), np.nan)
        self._received = np.full(nb_robots, -np.inf)
        self._complete = False
        for robot in range(1, nb_robots + 1):
            node.create_subscription(
                Odometry,
                topics.robot_topic(robot, topics.ODOM),
                partial(self._on_odometry, robot - 1),
                qos.STATE,
                event_callbacks=qos.no_subscription_events(),
            )

    def missing(self) -> list[int]:
        """Return the robots that have not been seen yet."""
        if self._complete:
            return []
        missing = [int(i) + 1 for i in np.flatnonzero(np.isinf(self._received))]
        self._complete = not missing
        return missing

    def age(self, robot: int) -> float:
        """Return how long ago a robot was last seen, in s."""
        return time.monotonic() - float(self._received[robot - 1])

    def theta(self, robot: int) -> float:
        """Return a robot's heading in rad; NaN if it has not been seen yet."""
        return float(self.poses[2, robot - 1])

    def _on_odometry(self, index: int, message: Odometry) -> None:
        position, q = message.pose.pose.position, message.pose.pose.orientation
        pose = (position.x, position.y, yaw_of_quaternion(q.x, q.y, q.z, q.w))
        if np.isfinite(pose).all():
            self.poses[:, index] = pose
            self._received[index] = time.monotonic()
