"""Control law: the student's function of one robot."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_ctrl import network
from setcmas_ctrl.communication.graph import complete
from setcmas_ctrl.laws.script_errors import ControlError
from setcmas_ctrl.laws.script_function import ScriptFunction, checked_function, file_of
from setcmas_ctrl.laws.script_loader import load_script
from setcmas_ctrl.laws.script_settings import Settings
from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.fleet.topics import robot_name

Velocity = tuple[float, float]
_RAISED_BY_NAN = (ValueError, FloatingPointError)  # by int, round, numpy.linalg, scipy


class ControlLaw:
    """The control law of one robot, with its own state.

    Attributes:
        path: The script, or the file of the function.
        robot: The number of its robot.
        nb_robots: Size of the fleet.
        names: Top-level names of the script, or of the module of the function, and their values.
    """

    def __init__(
        self,
        law: Path | Callable[..., Any],
        robot: int,
        nb_robots: int,
        settings: Settings | None = None,
    ) -> None:
        """Take a function, or load the script for a robot; settings replace values (`--set`).

        Raises:
            SetcmasError: The script does not load, or the function takes other arguments.
        """
        self.robot, self.nb_robots = robot, nb_robots
        if isinstance(law, Path):
            self.path = law
            self.names: Mapping[str, Any] = vars(load_script(law, robot, settings=settings))
            law = self.names.get('control', law)
        else:
            self.path = file_of(law, 'control')
            self.names = getattr(law, '__globals__', {})
        function = checked_function(law, self.path)
        self._control = ScriptFunction(
            function, self.path, 'control', expected='two finite numbers: return vx, vy'
        )

    def __call__(self, poses: Floats, t: float, adjacency: Floats | None = None) -> Velocity:
        """Return the velocity (vx, vy) in m/s from the script, which may ask `network`.

        Args:
            poses: Rows x, y in m and theta in rad, shape (3, N), NaN for robots whose poses
                this robot does not know; the script gets a copy.
            t: Time since the run started, in s.
            adjacency: Adjacency matrix, shape (N, N), read-only; None is complete.

        Raises:
            ControlError: The script raised, or did not return two finite numbers.
        """
        matrix = complete(self.nb_robots) if adjacency is None else adjacency
        try:
            with network.LawCall(self.robot, matrix):
                vx, vy = self._control(self.robot, self.nb_robots, poses.copy(), t)
        except ControlError as failure:
            cause = failure.__cause__
            note = _unknown_robots_note(self.robot, poses)
            may_be_nan = isinstance(cause, _RAISED_BY_NAN) and getattr(cause, 'is_nan', True)
            if may_be_nan and note not in failure.message:
                failure.message += note
            raise
        return vx, vy


def _unknown_robots_note(robot: int, poses: Floats) -> str:
    """Return a line break and the robots with NaN in the poses (3, N) of a robot; '' if none."""
    unknown = (np.flatnonzero(np.isnan(poses).any(axis=0)) + 1).tolist()
    if not unknown:
        return ''
    robots = robots_in_words(unknown)
    return (
        f'\n    {robot_name(robot)} receives nothing from {robots}: poses has NaN there; '
        'use network.neighbours() (from setcmas_ctrl import network)'
    )
