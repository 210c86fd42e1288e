"""Measured against predicted: the figures that a law predicts for a run, next to its metrics."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from setcmas_ctrl.communication.communication_settings import HELD
from setcmas_ctrl.control.prediction import (
    DOUBTS,
    PREDICT,
    LinearLaw,
    Predicted,
    RunConditions,
    texts_of,
)
from setcmas_ctrl.scripts.loader import ALGORITHMS, load_script
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.plugins import InvalidPluginError
from setcmas_simu.robots.model import Motion
from setcmas_simu.robots.models import motion_of
from setcmas_tools.measures.consensus_metrics import CONSENSUS, ConsensusMetrics, consensus
from setcmas_tools.measures.metric import Measured, words_and_unit
from setcmas_tools.measures.motion_metrics import largest_speed
from setcmas_tools.run.run import Run, channel_of, models_of

_AT_LIMIT = 0.999
_DIGITS = 6  # of what a sum that should be 0 has
_FAR_M = 1e6  # where a law is unstable
_MOST_ROBOTS, _MOST_CALLS = 250, 100_000  # a few seconds; a run may come from a stranger
_APART = 'distance_from_predicted_end_m'
_RATE, _CENTRE = 'convergence_rate_1_s', ('final_centre_x_m', 'final_centre_y_m')
_SPREAD = f'{CONSENSUS}.disagreement_rms_second_half_m'
_AT_END = f'{CONSENSUS}.disagreement_at_end_m'


@dataclass(frozen=True)
class Figure:
    """A figure that was predicted, and measured if its metric applies to the run.

    `predicted` is None for a distance from the prediction, which has a measured value only.
    """

    measured: float | None
    predicted: float | None
    formula: str


@dataclass(frozen=True)
class Comparison(Measured):
    """Figures that a law predicts.

    Attributes:
        figures: By the names of their metrics, such as 'consensus.convergence_rate_1_s'.
        differs: What the theory leaves out, and this run has.
        doubts: What the law needs, and these conditions do not give.
    """

    figures: Mapping[str, Figure]
    differs: tuple[str, ...]
    doubts: tuple[str, ...] = ()

    def lines(self) -> list[str]:
        """Return the figures under their formula, and what the theory leaves out."""
        lines, formula = [f'theory: {doubt}' for doubt in self.doubts], ''
        for name, one in self.figures.items():
            if one.formula != formula:
                formula = one.formula
                lines.append(f'predicted by {formula}:')
            predicted = '' if one.predicted is None else f', predicted {_number(one.predicted)}'
            words, unit = words_and_unit(name.rpartition('.')[2])
            unit = f' {unit}' if unit else ''
            lines.append(f'  {words} {_number(one.measured, unit)}{predicted}')
        if not lines:
            lines.append('theory: the law predicts nothing for these conditions')
        if self.figures and self.differs:
            lines.append(f'  the theory leaves out: {"; ".join(self.differs)}')
        return lines

    def as_dict(self) -> dict[str, Any]:
        """Return the predicted values, the distance from them, and what the theory leaves out."""
        values = {
            name.replace('.', '_'): one.measured if one.predicted is None else one.predicted
            for name, one in self.figures.items()
        }
        formulas = list(dict.fromkeys(one.formula for one in self.figures.values()))
        return {
            **values,
            'formulas': formulas,
            'left_out': list(self.differs),
            'doubts': list(self.doubts),
        }


def _number(value: float | None, unit: str = '') -> str:
    return 'unknown' if value is None else f'{round(value, _DIGITS) + 0.0:.3g}{unit}'


def compared(run: Run, parts: Mapping[str, Measured]) -> Comparison | None:
    """Return the figures that the law of a run predicts for its metrics; None if there are none.

    Only laws of installed packages predict, because this runs their code: a script of the run
    counts as such a law if it has the same text.

    Raises:
        InvalidPluginError: The run's settings do not fit its law, or `predict` returns something
            else.
    """
    found = _law(run)
    conditions = found and conditions_of(run)
    if not (found and conditions):
        return None
    law, title = found
    result = getattr(law, PREDICT)(conditions)
    if isinstance(result, LinearLaw):
        figures = _of_linear(run, result, conditions, parts)
    elif isinstance(result, Mapping) and all(isinstance(v, Predicted) for v in result.values()):
        figures = _figures(result, parts)
    else:
        raise InvalidPluginError(
            f'{PREDICT} of {title} must return a LinearLaw or values Predicted by metric'
        )
    delay_counts = isinstance(result, LinearLaw) and conditions.delay > 0.0
    theirs = {'delay': delay_counts, 'noise': _SPREAD in figures}
    differs = left_out(run, {name for name, known in theirs.items() if known})
    return Comparison(figures, tuple(differs), tuple(_doubts(run, law, result, conditions)))


def _doubts(run: Run, law: ModuleType, result: object, conditions: RunConditions) -> list[str]:
    """Return what the law needs, and these conditions do not give.

    Where the graph changes, that at the start decides nothing about a linear law.
    """
    own, changes = getattr(law, DOUBTS, None), _graph_changes(run)
    if isinstance(result, LinearLaw) and (changes or not own):
        return result.doubts(conditions.period, _is_consensus(run) and not changes)
    return texts_of(own, conditions) if own else []


def _law(run: Run) -> tuple[ModuleType, str] | None:
    """Return the run's law if it predicts, and its name.

    Raises:
        InvalidPluginError: The run's settings do not fit its law.
    """
    scripts = [one for one in run.inputs if one.option == 'algo']
    if len(scripts) != 1:
        return None
    for name in ALGORITHMS.plugins():
        try:
            path = ALGORITHMS.file(name)
        except SetcmasError:  # that of another package is damaged
            continue
        if path.read_bytes() == scripts[0].contents[0]:
            law = _loaded(path, run.parameters.get('set') or {})
            return (law, name) if callable(getattr(law, PREDICT, None)) else None
    return None


def _loaded(path: Path, settings: object) -> ModuleType:
    """Load a law with settings from the file of a run, which may be edited."""
    if not isinstance(settings, Mapping):
        raise InvalidPluginError(f"skipped: the run's settings are {settings!r}, no mapping")
    try:
        return load_script(path, 1, settings=settings)
    except SetcmasError as error:
        raise InvalidPluginError(f'skipped: {error}') from error


def conditions_of(run: Run) -> RunConditions | None:
    """Return the conditions of a run; None if they are unknown, or the run is too large."""
    grid, rate = run.counted_grid, float(run.parameters.get('rate') or 0.0)
    if not rate > 0.0 or not len(grid.t) or not np.isfinite(grid.x[:, 0]).all():
        return None
    count = len(grid.robots)
    duration = float(grid.t[-1] - grid.t[0])
    if count > _MOST_ROBOTS or duration * rate > _MOST_CALLS:
        return None
    adjacency = 1.0 - np.eye(count)
    if run.record:
        adjacency = run.record.adjacency(float(grid.t[0]), max(grid.robots))
        if len(adjacency) != count:
            return None
    starts = np.array([grid.x[:, 0], grid.y[:, 0], grid.theta[:, 0]])
    given, channel = run.parameters, channel_of(run, count)
    delay, noise = (
        _of_all(getattr(channel, name), adjacency) if channel else 0.0
        for name in ('delay', 'noise')
    )
    if robot_rate := float(given.get('robot_rate') or 0.0):  # only whole steps are sent
        delay = float(np.ceil(delay * robot_rate - 1e-6)) / robot_rate
    by_distance = given.get('event_triggered') and not given.get('ctc')
    threshold = float(given.get('threshold') or 0.0) if by_distance else 0.0
    holds_own = bool(given.get('event_triggered')) and given.get('own_state') == HELD
    reach = float(given.get('range') or np.inf)
    return RunConditions(
        starts, adjacency, 1.0 / rate, duration, delay, noise, threshold, holds_own, reach
    )


def _of_all(values: Floats, adjacency: Floats) -> float:
    """Return the value of all links; 0 if they differ."""
    found = np.unique(values[adjacency > 0])
    return float(found[0]) if len(found) == 1 else 0.0


def _of_linear(
    run: Run, law: LinearLaw, conditions: RunConditions, parts: Mapping[str, Measured]
) -> dict[str, Figure]:
    """Return the positions at the end, and of consensus its rate, centre and spread."""
    t, positions = law.positions(conditions)
    if not np.abs(positions[-1]).max() < _FAR_M:
        return {}
    formula = (
        f'z(k+1) = z(k) - h M {"z(k)" if np.all(law.offsets == 0.0) else "(z(k) - offsets)"}, '
        f'M = {law.formula}, h = {conditions.period:g} s'
    )
    ages = {'received': conditions.delay, 'own': law.own_delay}
    late = [f'{name} positions {age:g} s old' for name, age in ages.items() if age]
    formula = ', '.join([formula, *late])
    end = run.counted_grid
    apart = np.hypot(end.x[:, -1] - positions[-1, 0], end.y[:, -1] - positions[-1, 1])
    figures = {_APART: Figure(float(np.sqrt(np.mean(apart**2))), None, formula)}
    if not _is_consensus(run):
        return figures
    paths = positions.transpose(1, 2, 0)  # at the measured times: fits of oscillations need them
    x, y = np.array([[np.interp(end.t - end.t[0], t, one) for one in own] for own in paths])
    found = consensus(replace(end, x=x, y=y), np.zeros(len(x)))
    if not late:
        formula += f', slowest mode {law.slowest_rate:.3g} 1/s'
    for field in _CENTRE if law.own_delay else (_RATE, *_CENTRE):  # oscillations have no rate
        name, value = f'{CONSENSUS}.{field}', getattr(found, field, None)
        if value is not None:
            figures[name] = Figure(_measured(parts, name), round(value, _DIGITS) + 0.0, formula)
    figures = {name: replace(one, formula=formula) for name, one in figures.items()}
    if found and not late and len(law.matrix) == len(x):
        figures |= _figures(_spreads(law, conditions, found), parts)
    return figures


def _spreads(
    law: LinearLaw, conditions: RunConditions, found: ConsensusMetrics
) -> dict[str, Predicted]:
    """Return the disagreement that noise causes, and a bound of that which events cause."""
    spreads = {}
    if conditions.noise:
        spread = np.hypot(law.spread_by_noise(conditions), found.disagreement_rms_second_half_m)
        formula = f"P = B P B' + S, the covariance under noise of {conditions.noise:g} m"
        spreads[_SPREAD] = Predicted(float(spread), formula)
    if conditions.threshold:
        own = 'as sent, too (Seyboth et al., 2013)' if conditions.holds_own else 'exact'
        formula = (
            f'the upper bound for positions within {conditions.threshold:g} m of those sent, own '
            f'positions {own}'
        )
        spreads[_AT_END] = Predicted(law.spread_by_events(conditions), formula)
    return spreads


def _figures(found: Mapping[str, Predicted], parts: Mapping[str, Measured]) -> dict[str, Figure]:
    return {
        name: Figure(_measured(parts, name), one.value, one.formula)
        for name, one in found.items()
        if np.isfinite(one.value)
    }


def _is_consensus(run: Run) -> bool:
    return run.references is not None and run.references.task == CONSENSUS


def _graph_changes(run: Run) -> bool:
    return run.record is not None and len(np.unique(run.record.changes[:, 0])) > 1


def _measured(parts: Mapping[str, Measured], name: str) -> float | None:
    metric, _, field = name.partition('.')
    value = parts[metric].as_dict().get(field) if metric in parts else None
    return None if value is None else float(value)


def left_out(run: Run, known: Collection[str] = ()) -> list[str]:
    """Return what the theory of points without limits leaves out, and this run has.

    `known` are the properties of messages, 'delay' or 'noise', that it includes.
    """
    found = []
    if any(motion_of(model) is not Motion.FREE for model in models_of(run).values()):
        found.append('turning before driving')
    if run.commands is not None:
        t, speeds = run.commands.t, np.hypot(run.commands.vx, run.commands.vy)
        if (fast := speeds >= _AT_LIMIT * largest_speed(run)).any():
            found.append(f'the speed limit (reached until {t[fast].max():.1f} s)')
        drive = np.isin(run.commands.robot, np.unique(run.commands.robot[speeds > 0.0]))
        if (stopped := drive & (speeds == 0.0) & (t > t[0])).any():  # a memory may begin at 0
            found.append(f'robots at rest (from {t[stopped].min():.1f} s)')
    if run.record:
        if lost := sum(one.lost for one in run.record.links.values()):
            found.append(f'{lost:,} lost messages')
        if run.record.is_event_triggered:
            found.append('event-triggered communication')
        if _graph_changes(run):
            found.append('changes of the graph')
    if channel := channel_of(run, len(run.robots)):
        ignored = [name for name in ('delay', 'noise') if name not in known]
        found += [f'{name} of messages' for name in ignored if getattr(channel, name).any()]
    if run.commands is not None and run.commands.allowed is not None:
        found.append('the safety filter')
    return found
