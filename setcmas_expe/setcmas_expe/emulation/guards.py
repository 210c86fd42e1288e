"""Guards of emulated robots, which can hang, and start again with their robots."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence

from rclpy.logging import LoggingSeverity, set_logger_level

from setcmas_expe.emulation.schedule import Schedule
from setcmas_expe.guard.node import RATE_HZ, CmdVelGuard
from setcmas_expe.guard.options import GuardOptions
from setcmas_expe.lab.model import LabRobot
from setcmas_simu.fleet import topics


class EmulatedGuards:
    """The guards of some robots, by index."""

    def __init__(self, robots: Sequence[LabRobot], options: GuardOptions) -> None:
        """Start them."""
        self._robots = robots
        self._options = options
        self._guards = [self._guard(robot) for robot in robots]
        self._hang_until = [-math.inf] * len(robots)
        self._steps = Schedule(RATE_HZ)

    def hang(self, index: int, until: float) -> None:
        """Let one do nothing until a time (s)."""
        if self._guards:
            self._hang_until[index] = until

    def restart(self, index: int) -> None:
        """Let one begin anew."""
        if self._guards:
            self._guards[index].destroy_node()
            self._guards[index] = self._guard(self._robots[index])

    def step(self, now: float) -> None:
        """Step those that do not hang; `now` is in s."""
        due = self._steps.due(now)
        for guard, until in zip(self._guards, self._hang_until, strict=True):
            if now >= until and (due or guard.period < 1.0 / RATE_HZ):
                guard.step(now)

    def _guard(self, robot: LabRobot) -> CmdVelGuard:
        """Return the guard of a robot, which speaks up only when it stops the robot."""
        name = f'{robot.namespace}.{topics.CMD_VEL_GUARD_NODE}'.replace('/', '.')
        set_logger_level(name, LoggingSeverity.WARN)
        return CmdVelGuard(self._options, robot.namespace, time.monotonic())
