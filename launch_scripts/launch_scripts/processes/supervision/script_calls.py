"""Calls of scripts in a process: which failed, hangs, or was the last, as its launcher sees it."""

from __future__ import annotations

import time

from setcmas_simu.reports.current_call import CurrentCall
from setcmas_simu.reports.encoding import Message
from setcmas_simu.reports.reports import Ended, Failed, Function, ScriptCall, ScriptFailure, Stuck

SILENT_S = 3.0
"""Duration in s from which a call hangs that the process itself says nothing of.

A loop in C and a process that was stopped keep it from speaking.
"""


class ScriptCalls:
    """Follows the calls of one process by its reports and by the memory that both share.

    Attributes:
        failures: When which calls failed, as the process tells at its end.
    """

    def __init__(self, memory: int) -> None:
        """Share a file's memory with the process."""
        self._current = CurrentCall(memory)
        self._failed: dict[ScriptCall, None] = {}
        self._told_since = 0.0
        self.failures: tuple[ScriptFailure, ...] = ()

    @property
    def failed(self) -> tuple[ScriptCall, ...]:
        """The calls that failed, hung, or were running when the process was killed or died."""
        return tuple(self._failed)

    def hear(self, report: Message) -> None:
        """Take a report of the process."""
        if isinstance(report, Failed):
            self._failed[report.call] = None
        elif isinstance(report, Ended):
            self._failed |= dict.fromkeys(report.failed)
            self.failures = report.failures
        elif isinstance(report, Stuck):
            self._told_since = self._current.since
            self.note(report.call)

    def silently_hanging(self) -> ScriptCall | None:
        """Return a call that hangs without a word of the process; once for each."""
        if self.running_s <= SILENT_S or self._current.since == self._told_since:
            return None
        self._told_since = self._current.since
        return self.running()

    def running(self) -> ScriptCall | None:
        """Return the call that has not returned, and count it as failed; None between calls."""
        call = self._current.running()
        if call:
            self.note(call)
        return call

    def described(self) -> str:
        """Return in which call a process has ended, or after which; empty if there was none."""
        if call := self.running():
            return f' in {call}'
        return f' after {self.last()}' if self.last() else ''

    @property
    def missing(self) -> str:
        """Why control laws are not called yet."""
        call = self.running()
        return f'{call} has not returned' if call else 'the controllers have not called their laws'

    @property
    def running_s(self) -> float:
        """For how long a call has been running, in s; 0 between calls."""
        return self._current.running_s(time.monotonic())

    def last(self) -> ScriptCall | None:
        """Return the last call that began; None if there was none."""
        return self._current.last()

    def note(self, call: ScriptCall) -> None:
        """Count a call as failed; a script that is not loaded has not failed yet."""
        if call.function is not Function.LOADING:
            self._failed[call] = None
