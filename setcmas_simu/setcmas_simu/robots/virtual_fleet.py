"""State of a simulated fleet: poses and velocities."""

from __future__ import annotations

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.robots.model import POSE, RobotModel


class VirtualFleet:
    """Robots that hold their last command; their states are (S, N)."""

    def __init__(self, start_poses: Floats, model: RobotModel) -> None:
        """Place the robots at (3, N)."""
        self._model = model
        self.states: Floats = model.start(np.array(start_poses, dtype=float))
        self._commands = np.zeros((3, self.states.shape[1]))

    @property
    def poses(self) -> Floats:
        """Rows x, y in m and theta in rad, shape (3, N)."""
        return self.states[POSE]

    def command_all(self, commands: Floats) -> None:
        """Set finite commands for all robots, shape (3, N), which last until the next ones."""
        self._commands = commands

    def step(self, Ts: float) -> None:
        """Advance all robots by Ts s."""
        self.states = self._model.step(self.states, self._commands, Ts)
