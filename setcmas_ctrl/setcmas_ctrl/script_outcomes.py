"""Outcomes of scripts: which ones failed or hung, for the launcher and the exit status."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from operator import attrgetter
from pathlib import Path
from typing import NoReturn

from setcmas_ctrl.communication.triggering_conditions import CONSEQUENCE
from setcmas_ctrl.control_law import ControlLaw
from setcmas_ctrl.laws.call_watch import CallWatch
from setcmas_ctrl.laws.script_errors import STOPPED, ControlError, ErrorReports, StopCall
from setcmas_simu.reports import Ended, Failed, Launcher
from setcmas_simu.script_calls import Function, ScriptCall

_ENDS_ALL = 'this process exits: it can no longer command any robot'


class ScriptOutcomes:
    """Collects failed and stuck calls over all versions of a script."""

    def __init__(
        self,
        warn: Callable[[str], None],
        watch: CallWatch,
        launcher: Launcher,
        laws: Mapping[int, Path],
        robots: Sequence[int],
        condition: Path,
        conversion: Path,
    ) -> None:
        """Report each new error to the launcher, and all at the end.

        The laws are by robot; conditions and conversions are those of all robots.
        """
        self._warn = warn
        self.watch = watch
        self._launcher = launcher
        self._laws = laws
        self._failed: list[ScriptCall] = []
        self._unloaded: list[ScriptCall] = []  # of the newest version
        self.laws = self._reports(Function.CONTROL, laws)
        conditions = dict.fromkeys(robots, condition)
        self.conditions = self._reports(Function.CONDITION, conditions, CONSEQUENCE)
        conversions = dict.fromkeys(robots, conversion)
        self.conversions = self._reports(Function.SI_TO_UNI, conversions)
        # In later versions t starts at 0 again.
        self._first = self.laws, self.conditions, self.conversions

    @property
    def failed(self) -> tuple[ScriptCall, ...]:
        """Calls that have failed or hung at some time, and scripts that did not load."""
        failed = [*self._failed, *self.watch.have_been_stuck, *self._unloaded]
        return tuple(dict.fromkeys(failed))

    def begin_anew(self, loaded: bool) -> None:
        """Start anew for a new version of the script, which may have failed to load."""
        self._unloaded = []
        if not loaded:
            self._unloaded = [
                ScriptCall(robot, path.name, Function.LOADING)
                for robot, path in self._laws.items()
            ]
        self.laws = self._reports(Function.CONTROL, self._laws)
        self.conditions.begin_anew()
        self.conversions.begin_anew()

    def end_without_ros(self, law: ControlLaw, t: float) -> NoReturn:
        """Report that a law has shut down ROS in this process at time t (s); raise StopCall."""
        text = f'{law.path.name} has shut ROS down (rclpy.shutdown)'
        self.laws.failed(law.robot, t, ControlError(text, 'shutdown', _ENDS_ALL))
        raise StopCall

    def end(self) -> None:
        """Report the outcome to the launcher."""
        failures = sorted(
            (one for reports in self._first for one in reports.failures), key=attrgetter('t')
        )
        self._launcher.report(Ended(self.failed, tuple(failures)))

    def _reports(
        self, function: Function, scripts: Mapping[int, Path], consequence: str = STOPPED
    ) -> ErrorReports:
        note = partial(self._note, scripts, function)
        return ErrorReports(self._warn, consequence, note, function)

    def _note(
        self, scripts: Mapping[int, Path], function: Function, robot: int, text: str
    ) -> None:
        call = ScriptCall(robot, scripts[robot].name, function)
        self._failed.append(call)
        self._launcher.report(Failed(call, text))
