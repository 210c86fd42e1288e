"""Ladder: the law and the starts of a run, from single integrators to what was recorded.

Each rung adds one thing that the run has and the theory of its law leaves out. So the distance
of a rung from the one before says what that thing changes, given those before: in another order
it may be more or less.
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
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from tabulate import tabulate

from setcmas_ctrl.communication.communication_settings import CommunicationOptions
from setcmas_ctrl.laws.script_loader import names_to_set
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.robots.models import NO_LIMITS, UNICYCLE, is_model_file
from setcmas_tools.compare.run_distance import best_shift
from setcmas_tools.measures import consensus_metrics as consensus
from setcmas_tools.measures.task import ignore, rms, task_of
from setcmas_tools.offline.offline_run import OfflineRun
from setcmas_tools.plots.style import as_written, line_look
from setcmas_tools.run.fleet_motion import held_poses
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_info import State
from setcmas_tools.scenario.scenario import Scenario

CONTINUOUS_HZ = 100.0
"""Rate of laws and robots on the first rung, which is as good as continuous for these robots."""

DEAD_BAND = 'SLOW'
"""The name in a law of the speed in m/s below which its robots stop."""

_MESSAGES = {
    'event_triggered': 'events', 'delay': 'delay', 'loss': 'loss', 'noise': 'noise',
    'ctc': '', 'threshold': '', 'own_state': '',
}  # fmt: skip
"""Options that make messages imperfect, and what each adds, in words."""


@dataclass(frozen=True)
class Rung:
    """A run with some of what the recorded run has.

    Attributes:
        name: What it adds to the rung before.
        run: The run.
        step: Distance in m of its robots from those of the rung before, as root mean square;
            None on the first rung.
    """

    name: str
    run: Run
    step: float | None = None

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
        task = task_of(self.run, ignore)
        if task and (errors := task[0].errors(self.run, task[1])):
            values = np.sqrt(np.square(np.array([*errors.values.values()])).mean(axis=0))
            moving = np.zeros(len(values), bool)
            return float(values[-1]), consensus.convergence_rate(
                self.run.counted_grid.t, values, moving
            )
        if consensus.is_agreement(self.run) and (found := consensus.fleet_consensus(self.run)):
            return found.disagreement_at_end_m, found.convergence_rate_1_s
        return None, None


def ladder(run: Run, scenario: Scenario, warn: Callable[[str], None] = print) -> list[Rung]:
    """Return the rungs below a run, on which its law is simulated, and the run itself.

    Raises:
        SetcmasError: A robot of the scenario is not in the run, or the law fails.
    """
    if not scenario.law.is_scripts:
        raise SetcmasError('the law of this run is no script, so it cannot be simulated again')
    scenario = scenario.replace(
        poses=_starts(run, scenario.nb_robots), pose=(), random_poses=None,
        duration=float(np.ptp(run.counted.t)), rtf=1.0,
    )  # fmt: skip
    runs = {name: _simulated(rung, warn) for name, rung in _scenarios(scenario.found())}
    runs['as recorded'] = run
    steps = [rms([*best_shift(*pair).rms.values()]) for pair in pairwise(runs.values())]
    return [*map(Rung, runs, runs.values(), [None, *steps])]


def _scenarios(scenario: Scenario) -> Iterator[tuple[str, Scenario]]:
    """Yield the name and the scenario of each rung that adds something, the simplest first."""
    steps, before = _steps(scenario), None
    for number, (name, _) in enumerate(steps):
        rung = scenario.replace(**ChainMap(*(ideal for _, ideal in steps[number + 1 :])))
        if rung != before:
            yield name, rung
        before = rung


def _steps(scenario: Scenario) -> list[tuple[str, dict[str, Any]]]:
    """Return the name of each rung, and the values that the rungs below it have instead."""
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
        run = offline.result(call_timeout=10.0, warn=warn)
    if run.outcome.state is State.DIED:
        raise SetcmasError(str(run.outcome))
    return run


def _starts(run: Run, nb_robots: int) -> Floats:
    """Return the last poses of robots 1 to N before the first command moves them, (3, N)."""
    starts = held_poses(run.table, 0.0, range(1, nb_robots + 1))
    missing = np.flatnonzero(np.isnan(starts).any(axis=0))
    if len(missing):
        raise SetcmasError(f'robot {missing[0] + 1} has no pose in this run, so it has no start')
    return starts


def ladder_table(rungs: list[Rung]) -> str:
    """Return a row for each rung: its end, error, rate, and distance from the one before."""
    heads = 'rung|end x\n(m)|end y\n(m)|error at\nthe end|rate\n(1/s)|from the rung\nbefore (m)'
    rows = [[rung.name, *rung.end, *rung.error_and_rate, rung.step] for rung in rungs]
    table: str = tabulate(
        rows, heads.split('|'), floatfmt='.3f', missingval='-', colglobalalign='right',
        colalign=('left',),
    )  # fmt: skip
    return table.replace('-0.000', ' 0.000')


_SLIDE_IN = (12.0, 6.75)
_DOTS = 20  # along a path, about


def ladder_figure(rungs: list[Rung]) -> Figure:
    """Return the paths on each rung, with its end, rate and distance from the rung before.

    Dots along the paths show where robots are at equal times. Call and save within `plot_style`.
    """
    figure = Figure(figsize=_SLIDE_IN)
    panels = figure.subplots(2, math.ceil(len(rungs) / 2)).ravel()
    recorded = rungs[-1].run
    apart = _between_dots(float(recorded.counted.t[-1]))
    largest = max(rung.step or 0.0 for rung in rungs)
    for number, rung in enumerate(rungs):
        axes = panels[number]
        if number:
            _draw_paths(axes, rungs[number - 1].run, apart, is_before=True)
        _draw_paths(axes, rung.run, apart)
        weight = 'bold' if rung.step == largest else 'normal'
        axes.set_title(f'{number + 1}  {rung.name}', fontsize='medium', fontweight=weight)
        axes.set_xlabel(_caption(rung), fontsize='small', fontweight=weight)
        axes.set(aspect='equal', **_borders(recorded))
        axes.tick_params(labelsize='x-small')
    for axes in panels[len(rungs) :]:
        axes.set_axis_off()
    figure.suptitle(as_written(f'{recorded.title}: from single integrators to the run'))
    legend = f'grey: the rung before; dots: every {apart:g} s; bold: the largest step'
    figure.supxlabel(legend, fontsize='small', color='0.4')
    return figure


def _borders(run: Run) -> dict[str, tuple[float, float]]:
    """Return limits in m of both axes for a square around the paths of a run."""
    table = run.counted
    sides = [(np.nanmin(values), np.nanmax(values)) for values in (table.x, table.y)]
    half = 0.62 * max(1.0, *(high - low for low, high in sides))
    middles = [(low + high) / 2 for low, high in sides]
    return {f'{axis}lim': (m - half, m + half) for axis, m in zip('xy', middles, strict=True)}


def _between_dots(duration: float) -> float:
    """Return a round time in s, so that a path has about `_DOTS` dots."""
    least = duration / _DOTS
    size = 10.0 ** math.floor(math.log10(least))
    return next(size * step for step in (1, 2, 5, 10) if size * step >= least - 1e-9)


def _draw_paths(axes: Axes, run: Run, apart: float, is_before: bool = False) -> None:
    grid = run.counted_grid
    every = np.abs(grid.t / apart - np.round(grid.t / apart)) < 1e-6
    for robot, x, y in zip(grid.robots, grid.x, grid.y, strict=True):
        look = line_look(robot, len(grid.robots))
        if is_before:
            axes.plot(x, y, color='0.85', linewidth=5.0, zorder=1)
            axes.plot(x[every], y[every], 'o', color='0.65', ms=5.5, zorder=1.1)
        else:
            axes.plot(x, y, **look)
            axes.plot(x[every], y[every], 'o', color=look['color'], mec='0.15', mew=0.4, ms=3.0)
            axes.plot(x[:1], y[:1], 'o', mfc='white', mec=look['color'], ms=5.0, zorder=3)


def _caption(rung: Rung) -> str:
    x, y = (round(value, 2) + 0.0 for value in rung.end)
    rate = rung.error_and_rate[1]
    text = f'end ({x:.2f}, {y:.2f}) m' + ('' if rate is None else f', rate {rate:.3g} 1/s')
    return text if rung.step is None else f'{text}\n{rung.step:.3f} m (RMS) from the rung before'
