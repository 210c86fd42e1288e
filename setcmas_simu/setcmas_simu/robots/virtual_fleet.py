"""State of a simulated fleet: poses, velocities, steps and resets."""

from __future__ import annotations

import math

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.robots.model import POSE, TWIST, RobotModel
from setcmas_simu.robots.unicycle import Unicycle

Command = tuple[float, float, float]
"""Forward speed and speed to the left in m/s, and turn rate in rad/s."""

MOST_SPEED = 1e6
"""Largest speed of a command in m/s, and turn rate in rad/s."""
_REST: Command = (0.0, 0.0, 0.0)


class VirtualFleet:
    """Robots that hold their last command; their states are (S, N)."""

    def __init__(
        self, start_poses: Floats, model: RobotModel | None = None, cmd_timeout: float = 0.0
    ) -> None:
        """Place the robots at (3, N); they are unicycles by default.

        They stop `cmd_timeout` s after their last command; 0 is never.
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
        return self.states[POSE]

    @property
    def twists(self) -> Floats:
        """Forward and leftward speeds (m/s) and turn rates (rad/s) of the last step, (3, N)."""
        return self.states[TWIST]

    def use(self, model: RobotModel, cmd_timeout: float) -> None:
        """Change the robot model, for one with the same states, and the command time-out."""
        self.model, self._cmd_timeout = model, cmd_timeout

    def command(self, index: int, command: Command, now: float) -> bool:
        """Set the command, at a time in s, that a robot (a column) follows from the next step on.

        A command that is not finite, or beyond MOST_SPEED, stops the robot, as its pose would
        become infinite for good; then return False.
        """
        usable = all(abs(speed) <= MOST_SPEED for speed in command)
        self._commands[:, index] = command if usable else _REST
        self._command_times[index] = now
        return usable

    def command_all(self, commands: Floats) -> None:
        """Set finite commands for all robots, shape (3, N), which last until the next ones."""
        self._commands = commands

    def reset(self, index: int) -> None:
        """Return a robot to its start pose; it rests until the next command."""
        self.states[:, index] = self._start[:, index]
        self._commands[:, index] = 0.0

    def step(self, Ts: float, now: float = 0.0) -> None:
        """Advance all robots by Ts s; `now` is in s on the clock of `command`."""
        commands = self._commands
        if self._cmd_timeout:
            commands = commands * (now - self._command_times <= self._cmd_timeout)
        self.states = self.model.step(self.states, commands, Ts)
