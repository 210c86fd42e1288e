"""Watches calls of control scripts: tells of slow ones, and where one is stuck that hangs."""

from __future__ import annotations

import contextlib
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from setcmas_ctrl.script_messages import described_place, places_in, quoted_line
from setcmas_simu.topics import robot_name

STUCK_S = 2.0
"""Duration in s from which a call counts as stuck."""

_SLOW_REPORT_EVERY_S = 5.0


class _Call(NamedTuple):
    robot: int
    started: float
    late: str
    path: Path


class CallWatch:
    """Times each call on the thread that makes it, from a thread of its own."""

    def __init__(
        self,
        path: Path,
        period: float,
        say: Callable[[str], None],
        stuck_s: float = STUCK_S,
    ) -> None:
        """Start to watch.

        Args:
            path: The script.
            period: Control period in s; a longer call is slow.
            say: Shows a message to the user; called from either thread.
            stuck_s: Duration in s from which a call is stuck.
        """
        self._path = path
        self._period = period
        self._say = say
        self._stuck_s = stuck_s
        self.while_stuck: Callable[[], None] | None = None
        """Called now and then, from the watching thread, while a call is stuck."""
        self._call: _Call | None = None
        self._stuck: _Call | None = None
        self._longest = (0.0, 0)
        self._slow_steps = 0
        self._next_slow_report = 0.0
        self._caller = threading.get_ident()
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._watch, name='call watch', daemon=True)
        self._thread.start()

    @contextlib.contextmanager
    def call(
        self, robot: int, late: str = 'control has not returned', path: Path | None = None
    ) -> Iterator[None]:
        """Watch what runs inside as a call for a robot.

        Args:
            robot: Number of the robot.
            late: What is told of the call once it is stuck.
            path: The script, if it is another one.
        """
        started = time.monotonic()
        self._call = _Call(robot, started, late, path or self._path)
        try:
            yield
        finally:
            self._call = None
            self._longest = max(self._longest, (time.monotonic() - started, robot))

    @contextlib.contextmanager
    def step(self, nb_robots: int) -> Iterator[None]:
        """Watch what runs inside as the calls for all robots of a control period."""
        started = time.monotonic()
        self._longest = (0.0, 0)
        try:
            yield
        finally:
            duration = time.monotonic() - started
            if duration > self._period:
                self._report_slow(nb_robots, duration)

    @property
    def running_s(self) -> float:
        """For how long the present call has been running, in s; 0 between calls."""
        call = self._call
        return time.monotonic() - call.started if call else 0.0

    def close(self) -> None:
        """Stop to watch."""
        self._closed.set()
        self._thread.join()

    def _report_slow(self, nb_robots: int, duration: float) -> None:
        self._slow_steps += 1
        now = time.monotonic()
        if now >= self._next_slow_report:
            self._next_slow_report = now + _SLOW_REPORT_EVERY_S
            longest, robot = self._longest
            self._say(
                f'{self._path.name} took {duration:.2f} s for {nb_robots} robots '
                f'({longest:.2f} s for {robot_name(robot)}), longer than the control period of '
                f'{self._period:.2f} s (so far {self._slow_steps} times)'
            )

    def is_stuck(self) -> bool:
        """Return whether the present call is stuck."""
        return self.running_s > self._stuck_s

    def _watch(self) -> None:
        while not self._closed.wait(min(0.25, self._stuck_s / 4)):
            call = self._call
            if not call or not self.is_stuck():
                continue
            if call != self._stuck:
                self._stuck = call
                self._say(self._describe(call))
            if self.while_stuck:
                self.while_stuck()

    def _describe(self, call: _Call) -> str:
        frame = sys._current_frames().get(self._caller)
        # The innermost frame comes first.
        places = places_in(traceback.walk_stack(frame), call.path) if frame else []
        file, line = places[0] if places else (call.path, None)
        return (
            f'{robot_name(call.robot)}: {call.late} for {self._stuck_s:g} s; '
            f'it is at {described_place(file, line, call.path)}{quoted_line(file, line)}\n'
            '    no robot of this process is commanded until it returns; Ctrl-C stops'
        )
