"""Control law of one robot: calls the student's function and checks its result."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from math import inf, isfinite
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_ctrl import network
from setcmas_ctrl.control.prediction import DOUBTS, Conditions, Doubts, texts_of
from setcmas_ctrl.scripts.function import checked_function
from setcmas_ctrl.scripts.imports import helper_files
from setcmas_ctrl.scripts.loader import load_script
from setcmas_ctrl.scripts.script_errors import (
    ControlError,
    StopCall,
    failure_of,
    quoted_line,
    scripts_own,
    short_repr,
    unknown_robots_note,
)
from setcmas_ctrl.scripts.script_settings import Settings
from setcmas_simu.arrays import Floats

Velocity = tuple[float, float]
_FLOATS = (np.float64, float)
_RAISED_BY_NAN = (ValueError, FloatingPointError)  # by int, round, numpy.linalg, scipy
_EXPECTED = 'it must return two finite numbers: return vx, vy'


class ControlLaw:
    """The control law of one robot, with its own state.

    Attributes:
        path: The script, or the file of the function.
        names: Its top-level names and their values.
    """

    _doubts: Doubts | None = None  # still to be printed
    _first: tuple[float, Floats] | None = None  # time and poses of the first call

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
        self._nb_robots = nb_robots
        self._module = load_script(path, robot, settings=settings)
        self.names: Mapping[str, Any] = vars(self._module)
        self._control = checked_function(self.names.get('control'), path)
        if robot == 1 and callable(doubts := self.names.get(DOUBTS)):
            self._doubts = doubts

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
        law._nb_robots = nb_robots
        law._control = checked_function(control, law.path)
        law.names = getattr(control, '__globals__', {})
        return law

    def __call__(
        self,
        poses: Floats,
        t: float,
        adjacency: Floats | None = None,
    ) -> Velocity:
        """Return the velocity (vx, vy) in m/s from the script.

        Args:
            poses: Rows x, y in m and theta in rad, shape (3, N), NaN for robots whose poses
                this robot does not know; the script gets a copy.
            t: Time since the run started, in s.
            adjacency: Adjacency matrix for `network`, shape (N, N), read-only; None is complete.

        Raises:
            ControlError: The script raised, or did not return two finite numbers.
        """
        before = network.begin_call(self.robot, self._nb_robots, adjacency)
        try:
            if self._doubts:
                self._print_doubts(self._doubts, poses, t)
            result = self._control(self.robot, self._nb_robots, poses.copy(), t)
        except (StopCall, ControlError):  # ControlError: from another law
            raise
        except BaseException as error:  # whatever a script raises, the other robots continue
            if isinstance(error, KeyboardInterrupt) and not scripts_own(error):
                raise
            failure = failure_of(error, self.path)
            if isinstance(error, _RAISED_BY_NAN):
                text = f'{failure}{unknown_robots_note(self.robot, poses)}'
                failure = ControlError(text, failure.key, place=failure.place)
            raise failure from error
        finally:
            network.end_call(before)
        if type(result) is tuple and len(result) == 2:  # the usual case
            vx, vy = result
            if type(vx) in _FLOATS and type(vy) in _FLOATS and isfinite(vx) and isfinite(vy):
                return vx, vy
        try:
            return checked_velocity(result)
        except ValueError as error:
            line = self._first_line
            message = f'{self.path.name}: {error}; {_EXPECTED}{quoted_line(self.path, line)}'
            if 'not finite' in str(error):
                message += unknown_robots_note(self.robot, poses)
            kind = str(error).partition(':')[0]
            key = ('result', kind, type(result).__name__)
            raise ControlError(message, key, place=(self.path, line)) from error

    def _print_doubts(self, doubts: Doubts, poses: Floats, t: float) -> None:
        """Print why the law may not do what it should, at the second call: it shows the period."""
        start, starts = self._first = self._first or (t, poses.copy())
        if t > start:
            self._doubts = None
            period = max(round(t - start, 3), 0.001)  # over ROS calls are not evenly spaced
            conditions = Conditions(starts, network.adjacency(), period, inf)
            for doubt in texts_of(doubts, conditions):
                print(f'{self.path.stem}: {doubt}')

    @property
    def _first_line(self) -> int | None:
        code = getattr(self._control, '__code__', None)
        return code.co_firstlineno if code else None


def checked_velocity(result: Any) -> Velocity:
    """Convert the result of `control` to two floats.

    Accepts tuples, lists, arrays, numpy scalars and integers.

    Raises:
        ValueError: It is not two finite numbers; the message says what it is instead.
    """
    if result is None:
        raise ValueError('control returned None (is a return missing?)')
    try:
        array = np.asarray(result)
    except StopCall:
        raise
    except BaseException:  # it may be an object of the script's own
        raise ValueError(f'control returned values of unequal shapes: {_short(result)}') from None
    if array.dtype.kind not in 'iufb':
        raise ValueError(f'control returned a {type(result).__name__}: {_short(result)}')
    if array.size != 2:
        values = 'value' if array.size == 1 else 'values'
        raise ValueError(f'control returned {array.size} {values}: {_short(result)}')
    vx, vy = map(float, array.ravel().tolist())
    if not (isfinite(vx) and isfinite(vy)):
        raise ValueError(f'control returned a value that is not finite: {_short(result)}')
    return vx, vy


def _short(value: Any) -> str:
    return re.sub(r'np\.\w+\(([^()]*)\)', r'\1', short_repr(value))  # nan, not np.float64(nan)
