"""Outcome of the scripts of a controller process: who failed, who hung; told to the launcher."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from operator import attrgetter
from pathlib import Path

from setcmas_ctrl.communication.triggering import CONSEQUENCE
from setcmas_ctrl.scripts.error_reports import STANDS, ErrorReports
from setcmas_ctrl.scripts.watch.call_watch import CallWatch
from setcmas_simu.reports.launcher import Launcher
from setcmas_simu.reports.reports import Ended, Failed, Function, ScriptCall


class ScriptOutcomes:
    """Keeps which calls have failed or hung, over all versions of a script.

    Attributes:
        watch: Knows which calls have hung.
        laws: Takes the errors of control laws.
        conditions: Takes the errors of triggering conditions.
    """

    def __init__(
        self,
        warn: Callable[[str], None],
        watch: CallWatch,
        launcher: Launcher,
        laws: Mapping[int, Path],
        condition: Path,
    ) -> None:
        """Prepare.

        Args:
            warn: Shows a message to the user.
            watch: Knows which calls have hung.
            launcher: Is told of each error that is new, and of all at the end.
            laws: The script of each robot's control law.
            condition: The script of the triggering condition.
        """
        self._warn = warn
        self.watch = watch
        self._launcher = launcher
        self._laws = laws
        self._failed: list[ScriptCall] = []
        self._unloaded: list[ScriptCall] = []  # of the newest version
        self.laws = self._reports_of_laws()
        conditions = dict.fromkeys(laws, condition)
        self.conditions = ErrorReports(
            warn,
            CONSEQUENCE,
            partial(self._note, conditions, Function.CONDITION),
            Function.CONDITION,
        )
        self._first = self.laws, self.conditions  # those of later versions count t from 0 again

    @property
    def failed(self) -> tuple[ScriptCall, ...]:
        """The calls that have failed, or hung, at some time, and what could not be loaded."""
        failed = [*self._failed, *self.watch.have_been_stuck, *self._unloaded]
        return tuple(dict.fromkeys(failed))

    def begin_anew(self, loaded: bool) -> None:
        """Count the errors of a new version of the scripts from zero; it may not be loaded."""
        self._unloaded = [] if loaded else self._loadings()
        self._tell_counts(self.laws)
        self.laws = self._reports_of_laws()

    def end(self) -> None:
        """Say what was counted, and tell the launcher how it was."""
        self._tell_counts(self.laws)
        self._tell_counts(self.conditions)
        failures = sorted(
            (one for reports in self._first for one in reports.failures), key=attrgetter('t')
        )
        self._launcher.report(Ended(self.failed, tuple(failures)))

    def _reports_of_laws(self) -> ErrorReports:
        return ErrorReports(self._warn, STANDS, partial(self._note, self._laws, Function.CONTROL))

    def _loadings(self) -> list[ScriptCall]:
        return [
            ScriptCall(robot, path.name, Function.LOADING) for robot, path in self._laws.items()
        ]

    def _note(
        self, scripts: Mapping[int, Path], function: Function, robot: int, text: str
    ) -> None:
        call = ScriptCall(robot, scripts[robot].name, function)
        self._failed.append(call)
        self._launcher.report(Failed(call, text))

    def _tell_counts(self, reports: ErrorReports) -> None:
        for line in reports.summary():
            self._warn(line)
