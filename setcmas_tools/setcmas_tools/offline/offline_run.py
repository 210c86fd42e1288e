"""Offline run in a process of its own: a script that hangs or dies ends it, not the command."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from setcmas_simu.script_calls import ScriptFailure
from setcmas_tools.offline.offline_simulation import checked_steps, motion, simulate
from setcmas_tools.offline.run_progress import size_of
from setcmas_tools.offline.script_process import ScriptEndedError, ScriptProcess, Warn
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_info import Outcome, RunInfo, RunState
from setcmas_tools.run.scenario import Scenario


class OfflineRun(ScriptProcess[tuple[Run, float]]):
    """The process of a run; use as a context manager, which ends the process.

    Attributes:
        elapsed: How long the simulation took in s, without the start of the process.
    """

    def __init__(self, scenario: Scenario) -> None:
        """Prepare the run of a scenario from `Scenario.found`; raise SetcmasError if too large."""
        names = {one for key in ('model', 'si_to_uni', 'ctc') for one in scenario.named(key)}
        others = [Path(name) for name in names if name.endswith('.py')]
        super().__init__(
            partial(_simulated, scenario),
            [*scenario.law.scripts().paths, *others],
            size_of(checked_steps(scenario) + 1, scenario.nb_robots),
        )
        self._scenario = scenario
        self.elapsed = self._begin = 0.0

    def run(self, call_timeout: float, warn: Warn, look: Callable[[], object] = int) -> Run:
        """Simulate; return the run, or what was simulated until a script ended it.

        A call that does not return in time (s) ends it; `look` is called now and then, and at the
        end. Raises SetcmasError if the scenario or a script is invalid.
        """
        self._begin = time.perf_counter()
        try:
            run, self.elapsed = self.result(warn, call_timeout, look=look)
        except ScriptEndedError as error:
            return self._broken(error)
        look()
        return run

    def stopped(self) -> Run:
        """Return what was simulated until now, as stopped by the user; may have no states."""
        return self._remains(Outcome(RunState.STOPPED))

    def _broken(self, error: ScriptEndedError) -> Run:
        scripts, robot = self._scenario.law.scripts(), error.robot
        failed = {scripts.script(robot).name: [robot]} if robot else {}
        run = self._remains(Outcome(RunState.DIED, failed, {}, str(error)))
        t = float(run.table.t[-1]) if len(run.table.t) else 0.0
        failure = ScriptFailure(
            t, robot, error.function, error.file, error.line or None, error.reason
        )
        return replace(run, info=replace(run.info, failures=[failure]))

    def _remains(self, outcome: Outcome) -> Run:
        self.elapsed = time.perf_counter() - self._begin
        states = self.progress.states(self._scenario.nb_robots)
        times = np.arange(len(states)) / self._scenario.robots.robot_rate
        table = motion(times, states[:, :3], states[:, 3], states[:, 5])
        return Run(table, info=RunInfo(outcome=outcome))


def _simulated(scenario: Scenario, warn: Warn) -> tuple[Run, float]:
    """Simulate in this process; return the run, and the time that it took in s."""
    begin = time.perf_counter()
    return simulate(scenario, warn=warn), time.perf_counter() - begin
