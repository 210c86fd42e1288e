"""Explanation of a run, step by step, from single integrators to what was recorded.

Each step simulates the law of the run from its starts, and adds one thing that the run has and
the theory of its law leaves out. So the distance of a step from the one before says what that
thing changes, given those before: in another order it may be more or less.
"""

from __future__ import annotations

import math
from collections import ChainMap
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from tabulate import tabulate

from setcmas_ctrl.communication.communication_options import CommunicationOptions
from setcmas_ctrl.laws.script_loader import names_to_set
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.robots.models_by_name import NO_LIMITS, UNICYCLE, is_model_file
from setcmas_tools.measures import agreement
from setcmas_tools.measures.comparison import best_shift
from setcmas_tools.measures.task_errors import errors_of, rms
from setcmas_tools.offline.offline_run import OfflineRun
from setcmas_tools.run.fleet_motion import held_poses
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_info import RunState
from setcmas_tools.run.scenario import Scenario

CONTINUOUS_HZ = 100.0
"""Rate of laws and robots in the first step, which is as good as continuous for these robots."""

DEAD_BAND = 'SLOW'
"""The name in a law of the speed in m/s below which its robots stop."""

_MESSAGES = {
    'event_triggered': 'events', 'delay': 'delay', 'loss': 'loss', 'noise': 'noise',
    'ctc': '', 'threshold': '', 'own_state': '',
}  # fmt: skip
"""Options that make messages imperfect, and what each adds, in words."""


@dataclass(frozen=True)
class ExplainedStep:
    """A run with some of what the recorded run has.

    Attributes:
        name: What it adds to the step before.
        run: The run.
        distance: Root mean square distance in m of its robots from those of the step before; None
            in the first step.
    """

    name: str
    run: Run
    distance: float | None = None

    @property
    def end(self) -> tuple[float, float]:
        """Where the centre of the robots is at the end, x and y in m."""
        grid = self.run.counted_grid
        return float(np.nanmean(grid.x[:, -1])), float(np.nanmean(grid.y[:, -1]))

    @property
    def error_and_rate(self) -> tuple[float | None, float | None]:
        """The error of the task at the end, and the rate in 1/s at which it falls.

        In consensus, the error is the disagreement in m. None: unknown, or it hardly falls.
        """
        if errors := errors_of(self.run):
            values = np.sqrt(np.square(np.array([*errors.values.values()])).mean(axis=0))
            moving = np.zeros(len(values), bool)
            return float(values[-1]), agreement.convergence_rate(
                self.run.counted_grid.t, values, moving
            )
        if agreement.is_agreement(self.run) and (found := agreement.fleet_consensus(self.run)):
            return found.disagreement_at_end_m, found.convergence_rate_1_s
        return None, None


def explanation(
    run: Run, scenario: Scenario, warn: Callable[[str], None] = print
) -> list[ExplainedStep]:
    """Return the steps up to a run, in which its law is simulated, and the run itself.

    Raises:
        SetcmasError: A robot of the scenario is not in the run, or the law fails.
    """
    if not scenario.law.is_scripts:
        raise SetcmasError('the law of this run is no script, so it cannot be simulated again')
    scenario = scenario.replace(
        poses=_starts(run, scenario.nb_robots), pose=(), random_poses=None,
        duration=float(np.ptp(run.counted.t)), rtf=1.0,
    )  # fmt: skip
    runs = {name: _simulated(step, warn) for name, step in _scenarios(scenario.found())}
    runs['as recorded'] = run
    distances = [rms([*best_shift(*pair).rms.values()]) for pair in pairwise(runs.values())]
    return [*map(ExplainedStep, runs, runs.values(), [None, *distances])]


def _scenarios(scenario: Scenario) -> Iterator[tuple[str, Scenario]]:
    """Yield the name and the scenario of each step that adds something, the simplest first."""
    steps, before = _steps(scenario), None
    for number, (name, _) in enumerate(steps):
        step = scenario.replace(**ChainMap(*(ideal for _, ideal in steps[number + 1 :])))
        if step != before:
            yield name, step
        before = step


def _steps(scenario: Scenario) -> list[tuple[str, dict[str, Any]]]:
    """Return the name of each step, and the values that the steps before it have instead."""
    law, model = scenario.law, str(scenario.robots.model or UNICYCLE)
    messages, perfect = scenario.communication.values(), CommunicationOptions().values()
    imperfections = [text for name, text in _MESSAGES.items() if text and messages[name]]
    can_creep = all(DEAD_BAND in names_to_set(path) for path in law.scripts().paths)
    without_dead_band = {**law.set, DEAD_BAND: 0.0} if can_creep else law.set
    points = {'model': 'omnidirectional', 'limits': NO_LIMITS, 'si_to_uni': None}
    is_identified = is_model_file(model)
    kind = UNICYCLE if is_identified else Path(model).stem
    limits = '' if scenario.robots.limits == NO_LIMITS else f', limits {scenario.robots.limits}'
    return [
        ('single integrators', {}),
        ('sampled', {'rate': CONTINUOUS_HZ, 'robot_rate': CONTINUOUS_HZ}),
        ('with speed limit', {'vnom': math.inf}),
        ('with dead band', {'set': without_dead_band}),
        (f'as {kind}{limits}', points),
        (f'with {" and ".join(imperfections)}', {name: perfect[name] for name in _MESSAGES}),
        ('with safety filter', {'filter': None, 'accel': None}),
        ('as identified robot', {'model': UNICYCLE} if is_identified else {}),
    ]


def _simulated(scenario: Scenario, warn: Callable[[str], None]) -> Run:
    with OfflineRun(scenario) as offline:
        run = offline.result(warn, call_timeout=10.0)
    if run.outcome.state is RunState.DIED:
        raise SetcmasError(str(run.outcome))
    return run


def _starts(run: Run, nb_robots: int) -> Floats:
    """Return the last poses of robots 1 to N before the first command moves them, (3, N)."""
    starts = held_poses(run.table, 0.0, range(1, nb_robots + 1))
    missing = np.flatnonzero(np.isnan(starts).any(axis=0))
    if len(missing):
        raise SetcmasError(f'robot {missing[0] + 1} has no pose in this run, so it has no start')
    return starts


def explanation_table(steps: list[ExplainedStep]) -> str:
    """Return a row for each step: its end, error, rate, and distance from the one before."""
    heads = 'step|end x\n(m)|end y\n(m)|error at\nthe end|rate\n(1/s)|from the step\nbefore (m)'
    rows = [[step.name, *step.end, *step.error_and_rate, step.distance] for step in steps]
    table: str = tabulate(
        rows, heads.split('|'), floatfmt='.3f', missingval='-', colglobalalign='right',
        colalign=('left',),
    )  # fmt: skip
    return table.replace('-0.000', ' 0.000')
