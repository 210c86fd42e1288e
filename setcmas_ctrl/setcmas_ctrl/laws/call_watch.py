"""Monitor of calls of scripts: reports slow calls, and calls that never return."""

from __future__ import annotations

import contextlib
import math
import sys
import threading
import time
import traceback
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path

from setcmas_ctrl.laws.script_errors import StopCall, described_place, places_in, quoted_line
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.reports import Launcher
from setcmas_simu.script_calls import Function, ScriptCall

_REPORT_EVERY_S = 5.0


class SlowCalls:
    """Adds up the duration of the calls of scripts in a control period.

    Attributes:
        period: Time in s for the calls of all robots; unlimited until the control loop sets it.
    """

    def __init__(self, warn: Callable[[str], None]) -> None:
        self.period = math.inf
        self._warn = warn
        self._spent: defaultdict[tuple[Path, int], float] = defaultdict(float)
        self._times = 0
        self._next_report = -math.inf

    def add(self, path: Path, robot: int, duration: float) -> None:
        """Record a call of a script for a robot and its duration in s."""
        self._spent[path, robot] += duration

    def end_period(self, now: float) -> None:
        """End a control period at a time in s, and report now and then that it was too long."""
        spent = sum(self._spent.values())
        if spent > self.period:
            self._times += 1
            if now >= self._next_report:
                self._next_report = now + _REPORT_EVERY_S
                self._report(spent)
        self._spent.clear()

    def _report(self, spent: float) -> None:
        path, robot = max(self._spent, key=self._spent.__getitem__)
        robots = len({number for _, number in self._spent})
        self._warn(
            f'scripts took {spent:.2f} s for {robots} robot{"s" * (robots > 1)} '
            f'({self._spent[path, robot]:.2f} s of it {path.name} for {robot_name(robot)}), '
            f'longer than the control period of {self.period:.2f} s '
            f'({self._times} time{"s" * (self._times > 1)} so far)'
        )


STUCK_S = 2.0
"""Duration in s after which a call counts as stuck."""


class CallWatch:
    """Times the calls of the main thread, from its own thread."""

    def __init__(
        self, warn: Callable[[str], None], launcher: Launcher, stuck_s: float = STUCK_S
    ) -> None:
        """Start the monitor, which calls `warn` from either thread.

        A call counts as stuck after `stuck_s`. The launcher sees the current call, too.
        """
        self._warn = warn
        self._stuck_s = stuck_s
        self.have_been_stuck: list[ScriptCall] = []
        """Calls that have been stuck at some time."""
        self._call = launcher.current_call
        self._path = Path()
        self.slow = SlowCalls(warn)
        self._counting = False
        self._caller = threading.get_ident()
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._watch, name='call watch', daemon=True)
        self._thread.start()

    @contextlib.contextmanager
    def call(
        self, robot: int, path: Path, function: Function = Function.CONTROL
    ) -> Iterator[None]:
        """Monitor the code inside as a call of a script's function for a robot."""
        self._path = path
        self._call.begin(robot, path, function)
        try:
            yield
        finally:
            self._call.end()
            if function is not Function.LOADING and self._counting:
                self.slow.add(path, robot, time.monotonic() - self._call.since)

    def begin_period(self) -> None:
        """Count the time of calls from now on."""
        self._counting = True

    def end_period(self) -> None:
        """Report scripts that were too slow in the control period that ends now."""
        self.slow.end_period(time.monotonic())

    @property
    def running_s(self) -> float:
        """How long the current call has been running, in s; 0 between calls."""
        return self._call.running_s(time.monotonic())

    def stop_call(self) -> None:
        """Raise StopCall if a call is running; the kernel ends one that swallows the exception."""
        if self.running_s:
            raise StopCall

    def close(self) -> None:
        """Stop the monitor."""
        self._closed.set()
        self._thread.join()

    def _watch(self) -> None:
        while not self._closed.wait(min(0.25, self._stuck_s / 4)):
            call = self._call.running()
            if call and self.running_s > self._stuck_s and not self._call.is_reported:
                self._call.is_reported = True
                self._report(call, self._path)

    def _report(self, call: ScriptCall, path: Path) -> None:
        if call.function is not Function.LOADING:
            self.have_been_stuck.append(call)
        frame = sys._current_frames().get(self._caller)
        # The innermost frame comes first.
        places = places_in(traceback.walk_stack(frame), path) if frame else []
        file, line = places[0] if places else (path, None)
        place = described_place(file, line, path)
        self._warn(
            f'{robot_name(call.robot)}: {call.function.late(path.name, self._stuck_s)}; '
            f'it is at {place}{quoted_line(file, line)}\n'
            '    the robots of this process get no commands until it returns; Ctrl-C stops'
        )
