"""Limit on the time of a script's call, in a process that has neither a second thread nor signals.

Python reports each jump and each function call in scripts (`sys.monitoring`, from 3.12 on), which
takes a microsecond each; a late call raises an error there. Calls that hang inside a library are
not noticed.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from setcmas_ctrl.scripts import robot_script
from setcmas_ctrl.scripts.imports import robot_of_frame
from setcmas_ctrl.scripts.script_errors import StopCall
from setcmas_simu.reports.current_call import CurrentCall

_TOOL = 4
_ALIVE_S = 0.25


class LateCallError(StopCall):
    """A call of a script has not returned in time."""


@contextmanager
def limited_calls(
    notes: CurrentCall, seconds: float, alive: Callable[[], object]
) -> Iterator[None]:
    """Raise LateCallError in a script whose call takes longer than a limit.

    Args:
        notes: Where the process records its calls.
        seconds: The limit in s.
        alive: Called about every 0.25 s while scripts run.
    """
    monitoring: Any = getattr(sys, 'monitoring', None)
    if monitoring is None:  # Python before 3.12
        yield
        return
    watch = _Watch(notes, seconds, alive, monitoring.DISABLE)
    events = monitoring.events.JUMP, monitoring.events.PY_START
    before, robot_script.on_call = robot_script.on_call, lambda robot, _: notes.begin(robot)
    monitoring.use_tool_id(_TOOL, 'setcmas')
    for event in events:
        monitoring.register_callback(_TOOL, event, watch)
    monitoring.set_events(_TOOL, sum(events))
    try:
        yield
    finally:
        monitoring.set_events(_TOOL, 0)
        monitoring.free_tool_id(_TOOL)
        robot_script.on_call = before


class _Watch:
    """Is called where scripts jump or begin a function."""

    def __init__(
        self, notes: CurrentCall, seconds: float, alive: Callable[[], object], disable: object
    ) -> None:
        self._notes = notes
        self._seconds = seconds
        self._alive = alive
        self._disable = disable
        self._calls = -1
        self._since = self._reported = time.perf_counter()

    def __call__(self, *_: object) -> object:
        if robot_of_frame(sys._getframe(1)) is None:
            return self._disable
        now = time.perf_counter()
        if now - self._reported > _ALIVE_S:
            self._reported = now
            self._alive()
        notes = self._notes
        if notes.calls != self._calls or not notes.robot:
            self._calls, self._since = notes.calls, now
        elif now - self._since > self._seconds:
            self._reported = math.inf  # a script that catches this error is not alive
            raise LateCallError
        return None
