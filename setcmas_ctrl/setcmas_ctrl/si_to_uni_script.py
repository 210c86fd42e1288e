"""A user's own si_to_uni: a script for `--si-to-uni`, or in Python a function.

The script defines one function:

    def si_to_uni(velocity, pose, komega): return V, omega

velocity: vx, vy in m/s, in the world frame; pose: x, y (m), theta (rad); komega: gain on the
heading error in 1/s; V: forward speed in m/s; omega: turn rate in rad/s.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_ctrl.laws.control_options import SI_TO_UNI, GivenConversion
from setcmas_ctrl.laws.script_errors import ControlError, ErrorReports
from setcmas_ctrl.laws.script_function import ScriptFunction, checked_function, file_of
from setcmas_ctrl.laws.script_loader import load_script
from setcmas_simu.arrays import Floats


class ScriptConversion:
    """Drives one robot by a function, of its own copy of a script.

    Attributes:
        has_failed: Whether the last call has failed.
    """

    def __init__(
        self,
        function: Callable[..., Any] | Path,
        robot: int,
        reports: ErrorReports,
        time: Callable[[], float],
        during_call: Callable[[int, Path], AbstractContextManager[object]],
    ) -> None:
        """Take a function or load a script.

        `reports` gets the failures, at the `time` of the run in s; each call is made within what
        `during_call` returns for the robot and the path.

        Raises:
            SetcmasError: The script does not load, or the function takes other arguments.
        """
        self._function = load_conversion(function, robot)
        self.path = self._function.path
        self._robot, self._reports = robot, reports
        self.has_failed = False
        self._time, self._during_call = time, during_call

    def __call__(self, velocities: Floats, poses: Floats, komega: float) -> Floats:
        """Return commands (3, N) for velocities (2, N) of the robot at poses (3, N).

        They are zero where the function fails, and where a number is not finite.
        """
        commands = np.zeros(poses.shape)
        for column, (velocity, pose) in enumerate(
            zip(velocities.T.tolist(), poses.T.tolist(), strict=True)
        ):
            if all(map(math.isfinite, (*velocity, *pose))):
                commands[[0, 2], column] = self._called(tuple(velocity), tuple(pose), komega)
        return commands

    def _called(self, *arguments: Any) -> tuple[float, ...]:
        """Return V and omega, or report why they are zero."""
        try:
            with self._during_call(self._robot, self.path):
                answer = self._function(*arguments)
        except ControlError as error:
            self._reports.failed(self._robot, self._time(), error)
            self.has_failed = True
            return 0.0, 0.0
        self._reports.succeeded(self._robot, self._time())
        return answer


def load_conversion(given: Path | Callable[..., Any], robot: int) -> ScriptFunction:
    """Return a function, or that of a robot's own copy of a script, or raise SetcmasError."""
    if isinstance(given, Path):
        path, function = given, vars(load_script(given, robot, SI_TO_UNI)).get('si_to_uni')
    else:
        path, function = file_of(given, 'si_to_uni'), given
    function = checked_function(function, path, SI_TO_UNI, 'V, omega')
    expected = 'two finite numbers: return V, omega'
    return ScriptFunction(function, path, 'si_to_uni', expected=expected)


def script_conversions(
    given: GivenConversion,
    robots: Iterable[int],
    reports: ErrorReports,
    time: Callable[[], float],
    during_call: Callable[[int, Path], AbstractContextManager[object]],
) -> list[ScriptConversion]:
    """Return the conversion of each robot; none if the built-in si_to_uni drives them.

    The arguments and errors are those of `ScriptConversion`; a script must be a path.
    """
    if given is None:
        return []
    return [
        ScriptConversion(
            Path(given) if isinstance(given, (str, Path)) else _of_robot(given, robot),
            robot,
            reports,
            time,
            during_call,
        )
        for robot in robots
    ]


def _of_robot(given: Any, robot: int) -> Any:
    return given[robot] if isinstance(given, Mapping) else given
