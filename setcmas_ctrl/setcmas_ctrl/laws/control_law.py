"""Control law of one robot: calls the student's function and checks its result."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_ctrl.laws.script_errors import (
    ControlError,
    StopCall,
    failure_of,
    scripts_own,
    unknown_robots_note,
)
from setcmas_ctrl.laws.script_function import (
    WrongResultError,
    checked_function,
    numbers_of,
    wrong_result,
)
from setcmas_ctrl.laws.script_imports import helper_files
from setcmas_ctrl.laws.script_loader import load_script
from setcmas_ctrl.laws.script_settings import Settings
from setcmas_simu.arrays import Floats

Velocity = tuple[float, float]
_FLOATS = (np.float64, float)
_RAISED_BY_NAN = (ValueError, FloatingPointError)  # by int, round, numpy.linalg, scipy
_EXPECTED = 'it must return two finite numbers: return vx, vy'


class ControlLaw:
    """The control law of one robot, with its own state.

    Attributes:
        path: The script, or the file of the function.
        robot: The number of its robot.
        nb_robots: Size of the fleet.
        names: Its top-level names and their values.
    """

    def __init__(
        self, path: Path, robot: int, nb_robots: int, settings: Settings | None = None
    ) -> None:
        """Load the script for a robot; settings replace the script's own values (`--set`).

        Raises:
            SetcmasError: The script does not load.
        """
        self.path = path
        self.is_script = True
        self.robot = robot
        self.nb_robots = nb_robots
        self._module = load_script(path, robot, settings=settings)
        self.names: Mapping[str, Any] = vars(self._module)
        self._control = checked_function(self.names.get('control'), path)

    @property
    def files(self) -> list[Path]:
        """The script, and its helper modules imported so far."""
        return [self.path, *helper_files(self._module)]

    @classmethod
    def of_function(cls, control: Callable[..., Any], robot: int, nb_robots: int) -> ControlLaw:
        """Return a law that calls a function with four arguments, or raise SetcmasError."""
        law = cls.__new__(cls)
        code = getattr(control, '__code__', None)
        law.path = Path(code.co_filename if code else 'control')
        law.is_script = False
        law.robot = robot
        law.nb_robots = nb_robots
        law._control = checked_function(control, law.path)
        law.names = getattr(control, '__globals__', {})
        return law

    def __call__(
        self,
        poses: Floats,
        t: float,
    ) -> Velocity:
        """Return the velocity (vx, vy) in m/s from the script.

        Args:
            poses: Rows x, y in m and theta in rad, shape (3, N), NaN for robots whose poses
                this robot does not know; the script gets a copy.
            t: Time since the run started, in s.

        Raises:
            ControlError: The script raised, or did not return two finite numbers.
        """
        try:
            result = self._control(self.robot, self.nb_robots, poses.copy(), t)
        except (StopCall, ControlError):  # ControlError: from another law
            raise
        except BaseException as error:  # whatever a script raises, the other robots continue
            if isinstance(error, KeyboardInterrupt) and not scripts_own(error):
                raise
            failure = failure_of(error, self.path)
            if isinstance(error, _RAISED_BY_NAN):
                failure.message += unknown_robots_note(self.robot, poses)
            raise failure from error
        if type(result) is tuple and len(result) == 2:  # the usual case
            vx, vy = result
            if type(vx) in _FLOATS and type(vy) in _FLOATS and isfinite(vx) and isfinite(vy):
                return vx, vy
        try:
            vx, vy = numbers_of(result, (2,), 'control').tolist()
        except WrongResultError as error:
            failure = wrong_result(self._control, self.path, result, error, _EXPECTED)
            if error.is_nan:
                failure.message += unknown_robots_note(self.robot, poses)
            raise failure from error
        return vx, vy
