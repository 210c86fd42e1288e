"""Newest poses of a fleet in lockstep, from the array of each step."""

from __future__ import annotations

import numpy as np
from rclpy.node import Node
from rclpy.qos import QoSProfile

from setcmas_ctrl.driving.odometry import FleetOdometry, State
from setcmas_simu.fleet.planar_pose import yaw_of_quaternion
from setcmas_simu.ros.polling import PolledTopic
from setcmas_simu.simulator.lockstep import States
from setcmas_simu.simulator.lockstep_topics import StatesTopic


class LockstepOdometry(FleetOdometry):
    """The newest poses of robots in lockstep.

    Attributes:
        states: The topic with the states of all robots.
    """

    in_lockstep = True

    def _subscribed(self, node: Node, profile: QoSProfile) -> dict[int, PolledTopic]:
        del profile  # the array has its own
        self.states = StatesTopic(node, self._on_states)
        return {}

    def take(self, now: float) -> None:
        """Take the newest states; `now` is the time of the simulation in s."""
        super().take(now)
        self.states.take()

    def _on_states(self, states: States) -> None:
        numbers = states.table[:, 0].astype(int)
        rows = states.table[np.isin(numbers, self._followed)]
        indices = rows[:, 0].astype(int) - 1
        x, y, z, w = rows[:, 1:5].T
        self.stamps[indices] = states.stamp
        self.poses[:, indices] = x, y, yaw_of_quaternion(0.0, 0.0, z, w)
        self._received[indices] = self.now
        for index, row in zip(indices.tolist(), rows[:, 1:].tolist(), strict=True):
            form = self.states.forms.get(self.topic_of(index + 1))
            if form and self._listeners[index]:
                pose = tuple(self.poses[:, index].tolist())
                state = State(pose, row[4], form.at(states.stamp, row))
                for listener in self._listeners[index]:
                    listener(state)
