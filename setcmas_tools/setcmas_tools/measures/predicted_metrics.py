"""Measured against predicted: what theory says of the law of a run, next to its metrics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from setcmas_ctrl.law_predictions import (
    Conditions,
    Departure,
    predicted,
    predicted_law,
)
from setcmas_simu.robots.model import Motion
from setcmas_simu.robots.models_by_name import motion_of
from setcmas_tools.measures.metric import Measured, words_and_unit
from setcmas_tools.measures.robot_metrics import largest_speed
from setcmas_tools.run.fleet_motion import held_poses
from setcmas_tools.run.run import Run, models_of

_AT_LIMIT = 0.999
_DIGITS = 6  # of what a sum that should be 0 has


@dataclass(frozen=True)
class Figure:
    """A predicted figure, and the measured one if its metric applies to the run.

    Attributes:
        metric: Such as 'consensus.convergence_rate_1_s'.
    """

    metric: str
    measured: float | None
    predicted: float
    formula: str

    def line(self) -> str:
        """Return both values, and where the predicted one comes from."""
        words, unit = words_and_unit(self.metric.rpartition('.')[2])
        measured = '' if self.measured is None else f', measured {_number(self.measured)}'
        value = f'{_number(self.predicted)} {unit}'.rstrip()
        return f'theory: {words} {value} ({self.formula}){measured}'


class Comparison(Measured):
    """What theory says of a run.

    Attributes:
        figures: The predicted figures; the last one of a metric is the closest to the run.
        departures: What the theory leaves out and this run has, with a detail or ''.
        differs: The same as texts.
    """

    def __init__(self, figures: Sequence[Figure], departures: Mapping[Departure, str]) -> None:
        self.figures, self.departures = figures, departures
        self.differs = [
            f'{one.value} ({detail})' if detail else one.value
            for one, detail in departures.items()
        ]
        lines = [one.line() for one in figures]
        if lines and self.differs:
            lines.append(f'the theory leaves out: {"; ".join(self.differs)}')
        values = {
            **{one.metric.replace('.', '_'): _rounded(one.predicted) for one in figures},
            'formulas': list(dict.fromkeys(one.formula for one in figures)),
            'left_out': self.differs,
        }
        super().__init__(
            values, lines or ['theory: the law predicts nothing for these conditions']
        )

    def __contains__(self, metric: str) -> bool:
        return any(one.metric == metric for one in self.figures)

    def __getitem__(self, metric: str) -> Figure:
        """Return the last figure of a metric; KeyError if there is none."""
        return {one.metric: one for one in self.figures}[metric]


def _number(value: float) -> str:
    return f'{_rounded(value):.3g}'


def _rounded(value: float) -> float:
    return round(value, _DIGITS) + 0.0


def compared(run: Run, parts: Mapping[str, Measured]) -> Comparison | None:
    """Return what theory says of the law of a run and its metrics; None if it says nothing.

    Only built-in laws are predicted, because this runs their code: a script of the run counts as
    such a law if it has the same text.
    """
    scripts = [one.contents[0] for one in run.inputs if one.option == 'algo']
    name = predicted_law(scripts[0]) if len(scripts) == 1 else None
    if name is None or not (conditions := conditions_of(run)):
        return None
    left_out = departures(run)
    if {Departure.CHANGES, Departure.DELAY} & left_out.keys():  # such robots meet elsewhere
        return Comparison([], left_out)
    figures = [
        Figure(one.metric, _measured(parts, one.metric), one.value, one.formula)
        for one in predicted(name, run.parameters.get('set') or {}, conditions)
    ]
    return Comparison(figures, left_out)


def conditions_of(run: Run) -> Conditions | None:
    """Return the conditions of a run; None if they are unknown.

    Robots start at their last poses at or before the first command.
    """
    grid, given = run.counted_grid, run.parameters
    rate, count = float(given.get('rate') or 0.0), len(grid.robots)
    starts = held_poses(run.table, 0.0, grid.robots)
    if not rate or not len(grid.t) or not np.isfinite(starts).all():
        return None
    adjacency = 1.0 - np.eye(count)
    if run.record:
        adjacency = run.record.adjacency(float(grid.t[0]), max(grid.robots))
        if len(adjacency) != count:
            return None
    duration = float(grid.t[-1] - grid.t[0])
    return Conditions(starts, adjacency, 1.0 / rate, duration)


def _measured(parts: Mapping[str, Measured], name: str) -> float | None:
    metric, _, field = name.partition('.')
    value = parts[metric].values.get(field) if metric in parts else None
    return None if value is None else float(value)


def departures(run: Run) -> dict[Departure, str]:
    """Return what a run has and points without limits have not, each with a detail or ''."""
    given, commands, record = run.parameters, run.commands, run.record
    turns = any(motion_of(model) is not Motion.FREE for model in models_of(run).values())
    found: dict[Departure, str | bool] = {Departure.TURNING: turns}
    found[Departure.OWN_TURNING] = any(one.option == 'si_to_uni' for one in run.inputs)
    if commands is not None:
        t, speeds = commands.t, np.hypot(commands.vx, commands.vy)
        if (fast := speeds >= _AT_LIMIT * largest_speed(run)).any():
            found[Departure.SPEED_LIMIT] = f'reached until {t[fast].max():.1f} s'
        drive = np.isin(commands.robot, np.unique(commands.robot[speeds > 0.0]))
        if (stopped := drive & (speeds == 0.0) & (t > t[0])).any():  # a memory may begin at 0
            found[Departure.REST] = f'from {t[stopped].min():.1f} s'
        found[Departure.FILTER] = commands.allowed is not None
    if record:
        lost = sum(one.lost for one in record.links.values())
        found[Departure.LOSS] = f'{lost:,}' if lost else False
        found[Departure.EVENTS] = record.is_event_triggered
        found[Departure.CHANGES] = len(np.unique(record.changes[:, 0])) > 1
    found[Departure.DELAY] = bool(given.get('delay'))
    found[Departure.NOISE] = bool(given.get('noise'))
    return {one: '' if detail is True else detail for one, detail in found.items() if detail}
