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
"""Rows of a state: x, y (m), theta (rad); and velocities along the robot's axes over the last
step: forward, to the left (m/s), turn rate (rad/s)."""


class Motion(enum.Enum):
    """How robots can be made to go at a velocity."""

    UNICYCLE = 'a point ahead of the axle goes in every direction'
    FREE = 'the robot itself does'
    OTHER = 'neither does'


@runtime_checkable
class RobotModel(Protocol):
    """How N robots of one kind move, all at once; an object that keeps nothing between calls.

    States have the rows of POSE and TWIST, and may have further ones of the model's own. Commands
    have the rows of TWIST: they are what cmd_vel carries.

    Attributes:
        shape: What a robot looks like.
        V_max: The largest speed that it reaches in any direction in m/s.
        motion: How it can be made to go at a velocity.
        limits: Those of its speeds, if it has wheels.
        failed: Whether moving it has failed at some time, which only users' scripts do.
    """

    shape: Shape
    V_max: float = math.inf
    motion: Motion = Motion.UNICYCLE
    limits: VelocityLimits = IDEAL
    failed: bool = False

    def start(self, poses: Floats) -> Floats:
        """Return the states of robots that stand at poses (x, y in m, theta in rad; (3, N))."""
        return np.concatenate([poses, np.zeros((3, poses.shape[1]))])

    def command(self, velocities: Floats, poses: Floats, komega: float) -> Floats:
        """Return the commands that make robots go at velocities, as far as they can.

        Without a definition of its own a model is driven as a unicycle is, by `si_to_uni`.

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
        """Return the states a period later.

        Args:
            states: The states, shape (S, N), S as `start` gives it.
            commands: The commands that the robots follow, finite, shape (3, N).
            Ts: Period in s.

        Returns:
            The states, shape (S, N), in an array of their own.
        """
        ...

    def steps(self, states: Floats, commands: Floats, Ts: float, count: int) -> Floats:
        """Return the states after each of some periods, as `step` gives them, (count, S, N)."""
        later = np.empty((count, *states.shape))
        for row in later:
            row[:] = states = self.step(states, commands, Ts)
        return later
