"""Board on which an offline run notes how far it is, for whoever watches it from outside.

What stands there outlives the process, however a script ends it: the states so far, and the call
of a script that it is in. A note costs about a tenth of a microsecond.
"""

from __future__ import annotations

import mmap
from pathlib import Path

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.reports.reports import Function

HEAD = 64
"""Size of the notes before the states, in bytes."""
_CALLS, _ROBOT, _FUNCTION, _DONE, _STATES, _ROWS, _ROBOTS, _ELAPSED = range(8)
_FUNCTIONS = tuple(Function)


class Board:
    """Notes of a run: in memory of its own, or in a file that another process reads."""

    def __init__(self, path: Path | None = None) -> None:
        """Open a board; a file is created if it is not there."""
        self._path = path
        self._notes = memoryview(_mapped(path, HEAD) if path else bytearray(HEAD)).cast('q')

    @property
    def calls(self) -> int:
        """How many calls of scripts have begun."""
        return self._notes[_CALLS]

    @property
    def robot(self) -> int:
        """The robot for which a script is called; 0 between calls."""
        return self._notes[_ROBOT]

    @property
    def function(self) -> Function:
        """What of the script was called last."""
        return _FUNCTIONS[self._notes[_FUNCTION]]

    @property
    def done(self) -> int:
        """How many states are complete."""
        return self._notes[_DONE]

    @done.setter
    def done(self, states: int) -> None:
        self._notes[_DONE] = states

    @property
    def elapsed(self) -> float:
        """How long the run has taken in s; 0 before its end."""
        return self._notes[_ELAPSED] / 1e9

    @elapsed.setter
    def elapsed(self, seconds: float) -> None:
        self._notes[_ELAPSED] = round(seconds * 1e9)

    def begin(self, robot: int) -> None:
        """Note that a function of the present kind is called for a robot."""
        self._notes[_CALLS] += 1
        self._notes[_ROBOT] = robot

    def end(self) -> None:
        """Note that no script is called."""
        self._notes[_ROBOT] = 0

    def enter(self, function: Function) -> None:
        """Note what is called from now on."""
        self._notes[_FUNCTION] = _FUNCTIONS.index(function)

    def new_states(self, nb_states: int, nb_rows: int, nb_robots: int) -> Floats:
        """Return an array for the states of a run, shape (nb_states, nb_rows, nb_robots)."""
        shape = nb_states, nb_rows, nb_robots
        self._notes[_STATES], self._notes[_ROWS], self._notes[_ROBOTS] = shape
        return self._array(shape)

    def states(self) -> Floats:
        """Return the states that are complete."""
        shape = (self._notes[_STATES], self._notes[_ROWS], self._notes[_ROBOTS])
        return self._array(shape)[: self.done]

    def _array(self, shape: tuple[int, int, int]) -> Floats:
        if self._path is None:
            return np.empty(shape)
        size = 8 * shape[0] * shape[1] * shape[2]
        return np.frombuffer(_mapped(self._path, HEAD + size), offset=HEAD).reshape(shape)


def _mapped(path: Path, size: int) -> mmap.mmap:
    with path.open('ab') as file:
        if file.tell() < size:
            file.truncate(size)
    with path.open('r+b') as file:
        return mmap.mmap(file.fileno(), 0)


current = Board()
"""The board of the run that this process makes."""
