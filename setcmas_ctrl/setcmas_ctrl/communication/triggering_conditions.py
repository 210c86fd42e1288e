"""Triggering conditions: decide when a robot sends its state (event-triggered broadcast).

The student's condition is a function `ctc` in a script, in one of two forms:

    def ctc(pos, last_pos, t): -> bool
    def ctc(pos, vit, last_pos, last_vit, t): -> bool

pos: position x, y, 0 in m; vit: velocity vx, vy, 0 in m/s, both in the world frame; last_pos and
last_vit: the same in the last state sent; t: time since the start of the run, in s. Either form
may also have any of these keyword arguments:

    def ctc(pos, last_pos, t, *, received, measured): -> bool

received, measured: poses of the robot's neighbours at the last call of its law, as the robot had
received them, and as they really were; rows x, y in m and theta in rad, a column for each robot
of the fleet, NaN for robots that are not neighbours.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_ctrl.laws.script_errors import ControlError, ErrorReports
from setcmas_ctrl.laws.script_function import ScriptFunction
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError

Condition = Callable[..., Any]
State = tuple[tuple[float, float, float], float]
"""Pose x, y in m and theta in rad, and forward speed in m/s."""

THRESHOLD_M = 0.25
"""Default distance in m from the last position sent at which a robot sends its state."""

CTC = 'ctc(pos, last_pos, t)'
"""The function that a script with a condition must define, in its short form."""

CONSEQUENCE = 'sends its state whenever the condition fails'
"""What happens to a robot whose condition fails."""

NEIGHBOURS = RECEIVED, MEASURED = ('received', 'measured')
"""Keyword arguments that a condition may take: the poses of the robot's neighbours."""

_FORMS = f'{CTC} or ctc(pos, vit, last_pos, last_vit, t)'


def further_than(threshold: float) -> Condition:
    """Return the condition of the ROS 1 stack (Bertrand, ECC 2024).

    It triggers when the robot is further than the threshold (m) from the last position it sent.
    """

    def ctc(pos: Floats, last_pos: Floats, t: float) -> bool:
        del t
        dx, dy, _ = (pos - last_pos).tolist()
        return math.sqrt(dx * dx + dy * dy) > threshold

    return ctc


def takes_velocities(condition: Any, name: str) -> bool:
    """Return whether a condition has the form with velocities; `name` is that of its script.

    Raises:
        SetcmasError: It has neither form.
    """
    if not callable(condition):
        raise SetcmasError(f'{name} has no function ctc; it must have {_FORMS}')
    signature = inspect.signature(condition)
    poses = dict.fromkeys(_keywords_taken(condition))
    for nb_arguments in (3, 5):
        try:
            signature.bind(*range(nb_arguments), **poses)
        except TypeError:
            continue
        return nb_arguments == 5
    raise SetcmasError(
        f'{name}: ctc{signature} takes neither 3 nor 5 arguments; it must be {_FORMS}'
    )


def _keywords_taken(condition: Condition) -> list[str]:
    """Return which poses of neighbours a condition takes as keyword-only arguments."""
    parameters = inspect.signature(condition).parameters
    return [
        name
        for name in NEIGHBOURS
        if name in parameters and parameters[name].kind is inspect.Parameter.KEYWORD_ONLY
    ]


class Broadcast:
    """Decides at each odometry whether one robot sends its state.

    Attributes:
        last: The state sent last; None before the first.
        measures: Whether its condition takes the newest poses of its neighbours.
    """

    def __init__(self, robot: int, condition: Any, path: Path, reports: ErrorReports) -> None:
        """Prepare; the first state is always sent.

        Raises:
            SetcmasError: The condition has neither form.
        """
        self.robot = robot
        self._triggers = triggering(condition, path)
        self.path = path
        self._reports = reports
        self._with_velocities = takes_velocities(condition, path.name)
        self._neighbours = dict.fromkeys(_keywords_taken(condition), np.empty((3, 0)))
        self.measures = MEASURED in self._neighbours
        self.last: State | None = None

    def see(self, received: Floats, measured: Floats, weights: Floats) -> None:
        """Take the poses of the fleet, as received last and as they are, for the condition.

        Poses have the shape (3, N), weights that the robot gives others (N,), 0 without a link.
        """
        poses = {RECEIVED: received, MEASURED: measured}
        for name in self._neighbours:
            self._neighbours[name] = np.where(weights > 0.0, poses[name], np.nan)

    def is_triggered(self, pose: tuple[float, float, float], V: float, t: float) -> bool:
        """Return whether the robot sends its state now; True if the condition fails.

        The pose is x, y in m and theta in rad; the forward speed V is in m/s, t in s.
        """
        state = pose, V
        triggered = self.last is None or self._evaluate(state, self.last, t)
        if triggered:
            self.last = state
        return triggered

    def _evaluate(self, state: State, last: State, t: float) -> bool:
        # New arrays each time, so that a script cannot change the stored state.
        arguments = [_position(state), _position(last)]
        if self._with_velocities:
            arguments = [_position(state), _velocity(state), _position(last), _velocity(last)]
        neighbours = {name: poses.copy() for name, poses in self._neighbours.items()}
        try:
            (answer,) = self._triggers(*arguments, t, **neighbours)
        except ControlError as error:
            self._reports.failed(self.robot, t, error)
            return True
        self._reports.succeeded(self.robot, t)
        return bool(answer)


def triggering(condition: Condition, path: Path) -> ScriptFunction:
    """Return a condition, of a script, as a function that returns one number: 0 for no."""
    return ScriptFunction(condition, path, 'ctc', (1,), 'True or False')


def _position(state: State) -> Floats:
    x, y, _ = state[0]
    return np.array((x, y, 0.0))


def _velocity(state: State) -> Floats:
    (_, _, theta), V = state
    return np.array((V * math.cos(theta), V * math.sin(theta), 0.0))
