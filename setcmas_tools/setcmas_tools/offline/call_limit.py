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
from functools import partial
from typing import Any

from setcmas_ctrl.scripts import robot_script
from setcmas_ctrl.scripts.imports import robot_of_frame
from setcmas_ctrl.scripts.script_errors import StopCall
from setcmas_simu.reports.script_calls import Function
from setcmas_tools.offline import run_progress

_TOOL = 4
_ALIVE_S = 0.25


class LateCallError(StopCall):
    """A call of a script has not returned in time."""


@contextmanager
def limited_calls(seconds: float, alive: Callable[[], object]) -> Iterator[None]:
    """Raise LateCallError in a script whose call takes longer than a limit in s.

    Calls `alive` about every 0.25 s while scripts run.
    """
    monitoring: Any = getattr(sys, 'monitoring', None)
    if monitoring is None:  # Python before 3.12
        yield
        return
    call, disable = run_progress.current.call, monitoring.DISABLE
    calls, since, reported = -1, 0.0, time.perf_counter()

    def watch(*_: object) -> object:
        """Is called where scripts jump or begin a function."""
        nonlocal calls, since, reported
        if robot_of_frame(sys._getframe(1)) is None:
            return disable
        now = time.perf_counter()
        if now - reported > _ALIVE_S:
            reported = now
            alive()
        if call.calls != calls or not call.robot:
            calls, since = call.calls, now
        elif now - since > seconds:
            reported = math.inf  # a script that catches this error is not alive
            raise LateCallError
        return None

    events = monitoring.events.JUMP, monitoring.events.PY_START
    begin_step = partial(call.begin, function=Function.STEP)
    before, robot_script.on_call = robot_script.on_call, begin_step
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
