"""The state of a simulated fleet: poses, velocities, stepping and reset."""

from __future__ import annotations

import math

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.robots.model import POSE, TWIST, RobotModel
from setcmas_simu.robots.unicycle import Unicycle

Command = tuple[float, float, float]
"""Speeds forward and to the left in m/s and turn rate in rad/s."""

_STAND: Command = (0.0, 0.0, 0.0)


class VirtualFleet:
    """Robots that hold their last command, as those of the ROS 1 stack do.

    Attributes:
        states: The robots' states as their model has them, shape (S, N).
        model: How they move.
    """

    def __init__(
        self, start_poses: Floats, model: RobotModel | None = None, cmd_timeout: float = math.inf
    ) -> None:
        """Place the robots.

        Args:
            start_poses: Rows x, y in m and theta in rad, shape (3, N).
            model: How the robots move; as unicycles unless told.
            cmd_timeout: Age in s from which a command is no longer followed and the robot stops.
        """
        self.model = model or Unicycle()
        self._start = self.model.start(np.array(start_poses, dtype=float))
        self._cmd_timeout = cmd_timeout
        nb_robots = self._start.shape[1]
        self.states: Floats = self._start.copy()
        self._commands = np.zeros((3, nb_robots))
        self._command_times = np.full(nb_robots, -math.inf)

    @property
    def poses(self) -> Floats:
        """Rows x, y in m and theta in rad, shape (3, N)."""
        poses: Floats = self.states[POSE]
        return poses

    @property
    def twists(self) -> Floats:
        """Speeds forward and to the left (m/s) and turn rates (rad/s) of the last step, (3, N)."""
        twists: Floats = self.states[TWIST]
        return twists

    def use(self, model: RobotModel, cmd_timeout: float) -> None:
        """Move the robots from now on by a model with the same states, with another time-out."""
        self.model, self._cmd_timeout = model, cmd_timeout

    def command(self, index: int, command: Command, now: float) -> None:
        """Let a robot follow a command from the next step on.

        A command that is not finite stops the robot.

        Args:
            index: Column of the robot.
            command: What cmd_vel carries.
            now: Time in s on any steady clock, the same as in `step`.
        """
        self._commands[:, index] = command if all(map(math.isfinite, command)) else _STAND
        self._command_times[index] = now

    def command_all(self, commands: Floats, now: float) -> None:
        """Let all robots follow finite commands, shape (3, N), as `command` does."""
        self._commands[:] = commands
        self._command_times.fill(now)

    def reset(self, index: int) -> None:
        """Put a robot back to its start pose, at rest until the next command."""
        self.states[:, index] = self._start[:, index]
        self._commands[:, index] = 0.0

    def step(self, Ts: float, now: float) -> None:
        """Move all robots by one period of Ts s; `now` is in s on the clock of `command`."""
        commands = self._commands
        if self._cmd_timeout < math.inf:
            commands = commands * (now - self._command_times <= self._cmd_timeout)
        self.states = self.model.step(self.states, commands, Ts)

    def steps(self, Ts: float, count: int) -> Floats:
        """Move all robots by some periods of Ts s under their last commands, however old.

        Returns:
            The states after each period, shape (count, S, N).
        """
        later = self.model.steps(self.states, self._commands, Ts, count)
        self.states = later[-1]
        return later
