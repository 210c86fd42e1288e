"""Offline run in a process of its own: a script that hangs or dies ends it, not the command."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import inf

import numpy as np

from setcmas_simu.script_calls import ScriptFailure
from setcmas_tools.offline.offline_simulation import checked_steps, motion, simulate
from setcmas_tools.offline.run_progress import size_of
from setcmas_tools.offline.script_process import ScriptEndedError, ScriptProcess, Warn
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_folder import inputs_of, kept_record
from setcmas_tools.run.run_info import Outcome, RunInfo, RunState
from setcmas_tools.run.scenario import Scenario


class OfflineRun(ScriptProcess[Run]):
    """The process of a run; use as a context manager, which ends the process."""

    def __init__(self, scenario: Scenario) -> None:
        """Prepare the run of a scenario from `Scenario.found`; raise SetcmasError if too large."""
        size = size_of(checked_steps(scenario) + 1, scenario.nb_robots)
        super().__init__(partial(simulate, scenario), scenario.scripts(), size)
        self._scenario, self._inputs = scenario, tuple(inputs_of(scenario))

    def result(
        self,
        warn: Warn,
        call_timeout: float = inf,
        timeout: float = inf,
        look: Callable[[], object] = lambda: None,
    ) -> Run:
        """Simulate; return the run, or what was simulated until a script ended it.

        Arguments and SetcmasError are those of any `ScriptProcess`.
        """
        try:
            return super().result(warn, call_timeout, timeout, look)
        except ScriptEndedError as error:
            return self._broken(error)

    def stopped(self) -> Run:
        """Return what was simulated until now, as stopped by the user; may have no states."""
        return self._remains(Outcome(RunState.STOPPED))

    def _broken(self, error: ScriptEndedError) -> Run:
        robot = error.robot
        failed = {self.progress.call.script: [robot]} if robot else {}
        run = self._remains(Outcome(RunState.DIED, failed, str(error)))
        t = float(run.table.t[-1]) if len(run.table.t) else 0.0
        failure = ScriptFailure(
            t, robot, error.function, error.file, error.line or None, error.reason
        )
        return replace(run, info=replace(run.info, failures=[failure]))

    def _remains(self, outcome: Outcome) -> Run:
        self.elapsed = time.monotonic() - self._begin
        states = self.progress.states(self._scenario.nb_robots)
        times = np.arange(len(states)) / self._scenario.robots.robot_rate
        table = motion(times, states[:, :3], states[:, 3], states[:, 5])
        info = RunInfo(outcome=outcome, scenario=kept_record(self._scenario, self._inputs))
        return Run(table, info=info, inputs=self._inputs)
