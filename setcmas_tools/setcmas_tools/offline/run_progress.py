"""Progress of an offline run: its current call and its states, which another process may read.

In shared memory it survives the process of the run, however a script ends it.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from setcmas_ctrl.scripts.imports import calling_robot
from setcmas_simu.arrays import Floats
from setcmas_simu.reports.script_calls import Function

CALL_SIZE = 512
"""Bytes of memory for the current call."""
NB_ROWS = 6
"""Rows of the states: pose (m, rad), speeds forward and to the left (m/s), turn rate (rad/s)."""

_CALLS, _ROBOT, _FUNCTION, _LENGTH = range(4)
_NAME = 32  # where the name of the script begins
_FUNCTIONS = tuple(Function)


class RunProgress:
    """Current call and states of a run."""

    def __init__(self, call: memoryview | None = None, states: Floats | None = None) -> None:
        """Use shared memory of CALL_SIZE and `size_of`; by default, that of this process."""
        memory = memoryview(bytearray(CALL_SIZE)) if call is None else call
        self._numbers = memory[:_NAME].cast('q')
        self._name = memory[_NAME:]
        self._path: Path | None = None
        self._memory = np.zeros(1) if states is None else states
        self._is_shared = states is not None

    def enter(self, function: Function, path: Path | None = None) -> None:
        """Record which function of which script the next calls run."""
        self._numbers[_FUNCTION] = _FUNCTIONS.index(function)
        if path is not None and path is not self._path:
            self._path = path
            name = os.fsencode(path.name)[: len(self._name)]
            self._name[: len(name)] = name
            self._numbers[_LENGTH] = len(name)

    def begin(self, robot: int) -> None:
        """Record that a call begins for a robot."""
        self._numbers[_CALLS] += 1
        self._numbers[_ROBOT] = robot

    def begin_step(self, robot: int, path: Path) -> None:
        """Record that the script of a robot model is called for a robot."""
        self.enter(Function.STEP, path)
        self.begin(robot)

    def end(self) -> None:
        """Record that the call has returned."""
        self._numbers[_ROBOT] = 0

    @property
    def calls(self) -> int:
        """How many calls have begun."""
        return self._numbers[_CALLS]

    @property
    def robot(self) -> int:
        """The robot for which a script is called; 0 between calls."""
        return self._numbers[_ROBOT]

    @property
    def function(self) -> Function:
        """The function that was called last."""
        return _FUNCTIONS[self._numbers[_FUNCTION]]

    @property
    def script(self) -> str:
        """File name of the script that was called last."""
        return os.fsdecode(bytes(self._name[: self._numbers[_LENGTH]]))

    @property
    def done(self) -> int:
        """Number of complete states."""
        return int(self._memory[0])

    @done.setter
    def done(self, states: int) -> None:
        self._memory[0] = states

    def new_states(self, nb_states: int, nb_robots: int) -> Floats:
        """Return an array for the states of a run, shape (nb_states, NB_ROWS, nb_robots)."""
        if not self._is_shared:
            self._memory = np.zeros(size_of(nb_states, nb_robots))
        return self._memory[1:].reshape(nb_states, NB_ROWS, nb_robots)

    def states(self, nb_robots: int) -> Floats:
        """Return a copy of the complete states, shape (done, NB_ROWS, nb_robots)."""
        states: Floats = self._memory[1:].reshape(-1, NB_ROWS, nb_robots)[: self.done].copy()
        return states


def size_of(nb_states: int, nb_robots: int) -> int:
    """Return how many numbers a run needs: its states and their count."""
    return 1 + nb_states * NB_ROWS * nb_robots


current = RunProgress()
"""The progress of the run in this process."""


@contextmanager
def of_run() -> Iterator[None]:
    """Keep the current progress for its run: a run that a script starts gets one of its own."""
    global current
    before = current
    if calling_robot() is not None:
        current = RunProgress()
    try:
        yield
    finally:
        current = before
