"""Robot script: a robot model in a user's script, `--model my_robot.py`.

The script defines a function `step`, and optionally two others:

    def step(state, command, Ts): return x, y, theta, ...
    def start(x, y, theta): return x, y, theta, ...
    def command(velocity, pose): return V, omega

state: the last return value of step or start, with the pose x, y (m), theta (rad) first; without
start, the pose. command: speeds forward and to the left (m/s) and turn rate (rad/s), as on
cmd_vel. velocity: vx, vy (m/s) in the world frame. Without command, the robot is driven as a
unicycle; command may also return the speed to the left: forward, left, omega.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_ctrl.laws.script_errors import ControlError, ErrorReports
from setcmas_ctrl.laws.script_function import ScriptFunction, checked_function
from setcmas_ctrl.laws.script_loader import load_script
from setcmas_ctrl.laws.script_seeds import seed_scripts, seeded_generators
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.robots.model import POSE, TWIST, Motion, RobotModel
from setcmas_simu.robots.unicycle import BURGER_SHAPE, velocities_between

STEP = 'step(state, command, Ts)'
"""The function that a robot script must define."""

_FUNCTIONS: tuple[tuple[str, str, str, tuple[int, ...] | range], ...] = (
    ('step', STEP, 'x, y, theta', (3,)),
    ('start', 'start(x, y, theta)', 'numbers', range(3, 1000)),
    ('command', 'command(velocity, pose)', 'numbers', (2, 3)),
)
"""Names of functions, their forms, what they return, and how many numbers these are."""

_STOPS = 'stops; the other robots continue'
_process = ExitStack()


class ScriptRobot(RobotModel):
    """One robot with its own copy of a script; drawn as a unicycle.

    Its state has the rows of POSE and TWIST, then the script's values after the pose.
    """

    shape = BURGER_SHAPE

    def __init__(
        self,
        path: Path,
        robot: int,
        warn: Callable[[str], None],
        on_call: Callable[[int, Path], object],
    ) -> None:
        """Load the script, or raise SetcmasError; `warn` shows messages when it fails later.

        `on_call` is called with robot and script before each call.
        """
        self._on_call = on_call
        self._path = path.resolve()
        self._robot = robot
        functions = vars(load_script(self._path, robot, STEP))
        self._own = {
            name: ScriptFunction(
                checked_function(functions.get(name), self._path, form, result),
                self._path,
                name,
                sizes,
            )
            for name, form, result, sizes in _FUNCTIONS
            if name in functions or name == 'step'
        }
        if 'command' in self._own:
            self.motion = Motion.FREE  # as far as the script says
            self.command = self._command
        self.failed = False
        self._reports = ErrorReports(warn, _STOPS)
        self._t = 0.0

    @staticmethod
    def seed(seed: int) -> None:
        """Seed the random numbers of the scripts of this process, until it ends."""
        _process.enter_context(seeded_generators())
        seed_scripts(seed)

    def start(self, poses: Floats) -> Floats:
        """Return the state (3 + 3 or more, 1) at rest at a pose (3, 1), or raise SetcmasError."""
        state = super().start(poses)
        if 'start' not in self._own:
            return state
        try:
            arguments = tuple(poses[:, 0].tolist())
            own = np.array(self._own['start'](*arguments))
        except ControlError as error:
            raise SetcmasError(str(error)) from error
        self._own['step'].sizes = (len(own),)
        return np.concatenate([state, own[3:, None]])

    def _command(self, velocities: Floats, poses: Floats, _: float) -> Floats:
        """Return the command (3, 1) for a velocity (2, 1); zero if the script fails."""
        commands = np.zeros((3, 1))
        result = self._called('command', velocities[:, 0], poses[:, 0])
        if result is not None:
            commands[[0, 2] if len(result) == 2 else [0, 1, 2], 0] = result
        return commands

    def step(self, states: Floats, commands: Floats, Ts: float) -> Floats:
        """Return the state one period later; the robot stops if the script fails."""
        later: Floats = states.copy()
        later[TWIST] = 0.0
        own = np.concatenate([states[POSE, 0], states[TWIST.stop :, 0]])
        result = self._called('step', own, commands[:, 0].copy(), Ts)
        self._t += Ts
        if result is not None:
            later[POSE, 0], later[TWIST.stop :, 0] = result[:3], result[3:]
            later[TWIST] = _twist(states[POSE], later[POSE], Ts)
        return later

    def _called(self, name: str, *arguments: Any) -> Floats | None:
        """Call a function of the script; return its numbers, or None if it fails."""
        self._on_call(self._robot, self._path)
        try:
            result = np.array(self._own[name](*arguments))
        except ControlError as error:
            self.failed = True
            self._reports.failed(self._robot, self._t, error)
            return None
        self._reports.succeeded(self._robot, self._t)
        return result


def _twist(before: Floats, after: Floats, Ts: float) -> Floats:
    """Return the speeds forward and to the left and the turn rate between two poses (3, 1)."""
    V, omega = velocities_between(before, after, Ts)
    dx, dy = (after - before)[:2]
    left = (np.cos(after[2]) * dy - np.sin(after[2]) * dx) / Ts
    return np.stack([V, left, omega])
