"""The state of a simulated fleet: poses, applied velocities, stepping and reset."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.robots import unicycle
from setcmas_simu.robots.velocity_limits import IDEAL, VelocityLimits


class VirtualFleet:
    """Unicycles that hold their last command, as the robots of the ROS 1 stack do.

    Attributes:
        poses: Rows x, y in m and theta in rad, shape (3, N).
        V: Forward speeds over the last step in m/s, shape (N,).
        omega: Turn rates over the last step in rad/s, shape (N,).
    """

    def __init__(
        self,
        start_poses: NDArray[np.float64],
        limits: VelocityLimits = IDEAL,
        cmd_timeout: float = math.inf,
    ) -> None:
        """Place the robots.

        Args:
            start_poses: Rows x, y in m and theta in rad, shape (3, N).
            limits: How fast the robots can go.
            cmd_timeout: Age in s from which a command is no longer followed and the robot stops.
        """
        self._start_poses = np.array(start_poses, dtype=float)
        self._limits = limits
        self._cmd_timeout = cmd_timeout
        nb_robots = self._start_poses.shape[1]
        self.poses = self._start_poses.copy()
        self.V = np.zeros(nb_robots)
        self.omega = np.zeros(nb_robots)
        self._commands = np.zeros((2, nb_robots))
        self._command_times = np.full(nb_robots, -math.inf)

    def command(self, index: int, V: float, omega: float, now: float) -> None:
        """Let a robot follow a command from the next step on.

        A command that is not finite stops the robot.

        Args:
            index: Column of the robot.
            V: Forward speed in m/s.
            omega: Turn rate in rad/s.
            now: Time in s on any steady clock, the same as in `step`.
        """
        finite = math.isfinite(V) and math.isfinite(omega)
        self._commands[:, index] = (V, omega) if finite else (0.0, 0.0)
        self._command_times[index] = now

    def command_all(self, V: NDArray[np.float64], omega: NDArray[np.float64], now: float) -> None:
        """Let all robots follow finite commands (m/s, rad/s; shapes (N,)), as `command` does."""
        self._commands[0] = V
        self._commands[1] = omega
        self._command_times.fill(now)

    def reset(self, index: int) -> None:
        """Put a robot back to its start pose, at rest until the next command."""
        self.poses[:, index] = self._start_poses[:, index]
        self._commands[:, index] = 0.0
        self.V[index] = self.omega[index] = 0.0

    def step(self, Ts: float, now: float) -> None:
        """Move all robots by one period of Ts s; `now` is in s on the clock of `command`."""
        commands = self._commands.copy()
        if self._cmd_timeout < math.inf:
            commands *= now - self._command_times <= self._cmd_timeout
        self.V, self.omega = self._limits.saturate(*commands)
        self.poses = unicycle.step(self.poses, self.V, self.omega, Ts)
