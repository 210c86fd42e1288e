"""Progress of an offline run: its current call and its states.

In shared memory it survives the process of the run, however a script ends it, and another process
may read it.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from setcmas_ctrl.laws.script_imports import calling_robot
from setcmas_simu.arrays import Floats
from setcmas_simu.script_calls import CurrentCall

NB_ROWS = 6
"""Rows of the states: pose (m, rad), speeds forward and to the left (m/s), turn rate (rad/s)."""


class RunProgress:
    """Current call and states of a run.

    Attributes:
        call: The script call that it is in.
    """

    def __init__(self, call: CurrentCall | None = None, states: Floats | None = None) -> None:
        """Use shared memory, of `size_of` states; by default, that of this process."""
        self.call = CurrentCall() if call is None else call
        self._memory = np.zeros(1) if states is None else states
        self._is_shared = states is not None

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
