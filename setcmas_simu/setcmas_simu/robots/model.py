"""Robot model: how robots of one kind turn velocities into motion."""

from __future__ import annotations

import enum
import math
from typing import Protocol, runtime_checkable

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.robots.shape import Shape
from setcmas_simu.robots.si_to_uni import si_to_uni
from setcmas_simu.robots.velocity_limits import IDEAL, VelocityLimits

POSE, TWIST = slice(0, 3), slice(3, 6)
"""Rows of a state: x, y (m), theta (rad); and the velocities of the last step along the robot's
axes: forward, to the left (m/s), turn rate (rad/s)."""


class Motion(enum.Enum):
    """What can follow a velocity in any direction: a point of the robot, the robot, or nothing."""

    UNICYCLE = 'a point ahead of the axle goes in every direction'
    FREE = 'the robot itself does'
    OTHER = 'neither does'


@runtime_checkable
class RobotModel(Protocol):
    """How N robots of one kind move, all at once; models keep nothing between calls.

    States have the rows of POSE and TWIST, and any further rows that the model needs. Commands
    have the rows of TWIST, as on cmd_vel.

    Attributes:
        shape: Shape of a robot.
        V_max: Largest speed in any direction in m/s.
        motion: What can follow a velocity in any direction.
        limits: Speed limits, for robots with wheels.
        failed: Whether a step has failed; only users' scripts can fail.
    """

    shape: Shape
    V_max: float = math.inf
    motion: Motion = Motion.UNICYCLE
    limits: VelocityLimits = IDEAL
    failed: bool = False

    def start(self, poses: Floats) -> Floats:
        """Return the states of robots at rest at poses (x, y in m, theta in rad; (3, N))."""
        return np.concatenate([poses, np.zeros((3, poses.shape[1]))])

    def command(self, velocities: Floats, poses: Floats, komega: float) -> Floats:
        """Return the commands that give robots their velocities as far as possible.

        By default robots are driven as unicycles, by `si_to_uni`.

        Args:
            velocities: Rows vx, vy in m/s in the world frame, shape (2, N).
            poses: Rows x, y in m and theta in rad, shape (3, N).
            komega: Gain on the heading error in 1/s.

        Returns:
            The commands, shape (3, N).
        """
        commands = np.zeros(poses.shape)
        commands[0], commands[2] = si_to_uni(velocities, poses[2], komega)
        return commands

    def step(self, states: Floats, commands: Floats, Ts: float) -> Floats:
        """Return the states one period later.

        Args:
            states: The states, shape (S, N), with S rows as from `start`.
            commands: Finite commands of the robots, shape (3, N).
            Ts: Period in s.

        Returns:
            The new states, shape (S, N), in a new array.
        """
        ...

    def steps(self, states: Floats, commands: Floats, Ts: float, count: int) -> Floats:
        """Return the states after each of `count` periods, as from `step`, shape (count, S, N)."""
        later = np.empty((count, *states.shape))
        for row in later:
            row[:] = states = self.step(states, commands, Ts)
        return later
