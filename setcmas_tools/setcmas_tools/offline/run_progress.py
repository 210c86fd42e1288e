"""Progress of an offline run: its current call, whose time may be limited, and its states.

In shared memory it survives the process of the run, however a script ends it, and another process
may read it.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from setcmas_ctrl.laws.script_errors import StopCall
from setcmas_ctrl.laws.script_imports import calling_robot, robot_of_frame
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


_TOOL = 4
_ALIVE_S = 0.25


class LateCallError(StopCall):
    """A call of a script has not returned in time."""


@contextmanager
def limited_calls(seconds: float, alive: Callable[[], object]) -> Iterator[None]:
    """Raise LateCallError in a script whose call takes longer than a limit in s.

    Calls `alive` about every 0.25 s while scripts run. It is for a process that has neither a
    second thread nor signals: Python reports each jump and each function call in scripts
    (`sys.monitoring`, from 3.12 on), which takes a microsecond each; a late call raises an error
    there. Calls that hang inside a library are not noticed.
    """
    monitoring: Any = getattr(sys, 'monitoring', None)
    if monitoring is None:  # Python before 3.12
        yield
        return
    call, disable, reported = current.call, monitoring.DISABLE, time.monotonic()

    def watch(*_: object) -> object:
        """Is called where scripts jump or begin a function."""
        nonlocal reported
        if robot_of_frame(sys._getframe(1)) is None:
            return disable
        now = time.monotonic()
        if now - reported > _ALIVE_S:
            reported = now
            alive()
        if call.running_s(now) > seconds:
            reported = math.inf  # a script that catches this error is not alive
            raise LateCallError
        return None

    events = monitoring.events.JUMP, monitoring.events.PY_START
    monitoring.use_tool_id(_TOOL, 'setcmas')
    for event in events:
        monitoring.register_callback(_TOOL, event, watch)
    monitoring.set_events(_TOOL, sum(events))
    try:
        yield
    finally:
        monitoring.set_events(_TOOL, 0)
        monitoring.free_tool_id(_TOOL)
