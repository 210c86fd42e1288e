"""Criteria of a rubric, and the figures of a run that they bound."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from setcmas_simu.yaml_entries import Entry
from setcmas_tools.compare.run_distance import distances_between
from setcmas_tools.measures.metric import METRICS
from setcmas_tools.measures.metrics import measure
from setcmas_tools.run.fleet_motion import FleetGrid
from setcmas_tools.run.run import Run
from setcmas_tools.study.study_columns import COLUMNS, SHIPPED, numbers_of

_DIGITS = 9


@dataclass(frozen=True)
class Figure:
    """A number that a run is marked by.

    Attributes:
        unit: Its unit; empty if it has none.
        purpose: What it is.
    """

    unit: str
    purpose: str


COMPARED = {
    'path_error': Figure('m', 'RMS distance to the paths of the solution, at equal times'),
    'largest_path_error': Figure('m', 'largest distance to the paths of the solution'),
    'end_error': Figure('m', 'largest distance to the ends of the solution'),
    'path_ratio': Figure('', 'length of all paths, as a share of that of the solution'),
}
"""The figures of the comparison with the model solution."""

SAFETY = {
    'safety_stops': Figure('', 'how often robots were stopped'),
    'safety_stopped_s': Figure('s', 'time at which robots were stopped, added up'),
    'safety_overruled_s': Figure('s', 'time at which robots were held back, added up'),
    'safety_outside_arena_s': Figure('s', 'time outside the arena, added up'),
    'safety_too_near_s': Figure('s', 'time at which pairs of robots were too near, added up'),
}
"""The figures of experiments, such as those in the emulated lab."""

FIGURES = {
    **{name: Figure(column.unit, column.purpose) for name, column in COLUMNS.items()},
    **COMPARED,
    **SAFETY,
}
"""All figures, but for those of plugins."""


def is_plugins(name: str) -> bool:
    """Return whether a name may be a column of a metric of a plugin."""
    own = METRICS.offers().keys() - SHIPPED - {'safety'}
    return any(name.startswith(one) for one in own)


def figures_of(run: Run, solution: Run | None) -> dict[str, float | None]:
    """Return the figures of a run by name; None for what it has not.

    Args:
        run: The run; it must have the references of the solution.
        solution: The run of the model solution; None if there is none.
    """
    if not len(run.counted.t):
        return {}
    figures = numbers_of(measure(run, lambda _: None))
    return figures | (compared(run, solution) if solution else {})


def compared(run: Run, solution: Run) -> dict[str, float | None]:
    """Return how near a run is to that of the model solution."""
    _, apart = distances_between(run, solution)
    distances = np.array([*apart.values()])
    if not np.isfinite(distances).any():
        return dict.fromkeys(COMPARED)
    lengths = [_length(one.counted_grid) for one in (run, solution)]
    figures = {
        'path_error': float(np.sqrt(np.nanmean(distances**2))),
        'largest_path_error': float(np.nanmax(distances)),
        'end_error': float(np.nanmax(distances[:, -1])),
        'path_ratio': lengths[0] / lengths[1] if lengths[1] else None,
    }
    return {
        name: None if number is None else float(f'{number:.{_DIGITS}g}')
        for name, number in figures.items()
    }


def _length(grid: FleetGrid) -> float:
    """Return the length of the paths of all robots in m."""
    return float(np.nansum(np.hypot(np.diff(grid.x), np.diff(grid.y))))


_BOUNDS = ('at_most', 'below', 'at_least', 'above', 'between')
_KEYS = ('name', 'metric', *_BOUNDS, 'none_at', 'points', 'hint', 'hidden', 'needs')
_CENTS = 100  # points are told with two decimals


@dataclass(frozen=True)
class Bounds:
    """What is wanted of a number, and from where on there is nothing for it.

    Attributes:
        low: The number must be from here on; -inf if there is no such bound.
        high: The number must be up to here; inf if there is no such bound.
        strict: Whether the bounds themselves are outside.
        none_below: Nothing at this number and below; linear from here to `low`.
        none_above: Nothing at this number and above; linear from `high` to here.
    """

    low: float = -math.inf
    high: float = math.inf
    strict: bool = False
    none_below: float | None = None
    none_above: float | None = None

    def share(self, number: float | None) -> float:
        """Return how much of what is wanted a number is, from 0 to 1; 0 for no number."""
        if number is None or math.isnan(number):
            return 0.0
        if self.low < number < self.high or (not self.strict and number in (self.low, self.high)):
            return 1.0
        if number <= self.low:
            return _partial(number, self.none_below, self.low)
        return _partial(number, self.none_above, self.high)

    def words(self, unit: str) -> str:
        """Return the bounds in words, such as 'at most 0.05 m'."""
        unit = f' {unit}' if unit else ''
        if math.isfinite(self.low) and math.isfinite(self.high):
            return f'from {self.low:g} to {self.high:g}{unit}'
        if math.isfinite(self.low):
            return f'{"above" if self.strict else "at least"} {self.low:g}{unit}'
        return f'{"below" if self.strict else "at most"} {self.high:g}{unit}'


def _partial(number: float, none_at: float | None, bound: float) -> float:
    if none_at is None or none_at == bound:
        return 0.0
    return max(0.0, (number - none_at) / (bound - none_at))


@dataclass(frozen=True)
class Criterion:
    """What is wanted of a run, and what it is worth.

    Attributes:
        name: What is wanted in words, unique in its scenario.
        metric: What is measured: a name of `FIGURES`, or a column of a metric of a plugin.
        points: For a number within the bounds.
        bounds: What is wanted of the number.
        hint: What to tell a student who misses it; may be empty.
        hidden: Whether students see nothing of it but its points.
        needs: Another criterion of the scenario without whose points this one has none.
    """

    name: str
    metric: str
    points: float
    bounds: Bounds = field(default_factory=Bounds)
    hint: str = ''
    hidden: bool = False
    needs: str = ''

    @property
    def unit(self) -> str:
        """The unit of what is measured; empty if it has none."""
        return FIGURES[self.metric].unit if self.metric in FIGURES else ''

    @property
    def wanted(self) -> str:
        """The bounds in words."""
        return self.bounds.words(self.unit)

    def points_for(self, number: float | None) -> float:
        """Return the points for a number, rounded down to two decimals."""
        points = self.points * self.bounds.share(number)
        return math.floor(points * _CENTS + 1e-6) / _CENTS


def read_criteria(entry: Entry) -> tuple[Criterion, ...]:
    """Return the criteria that a list in a rubric tells.

    Raises:
        SetcmasError: There is none, or one has a mistake; the message has its line.
    """
    criteria: list[Criterion] = []
    for item in entry.items():
        criteria.append(_criterion(item, criteria))
    if not criteria:
        raise entry.mistake('a list with a criterion at least')
    return tuple(criteria)


def _criterion(entry: Entry, before: Sequence[Criterion]) -> Criterion:
    fields = entry.fields(_KEYS)
    metric = _metric(entry, fields)
    names = [one.name for one in before]
    bounds = _bounds(entry, fields)
    criterion = Criterion(
        name=fields['name'].text() if 'name' in fields else '',
        metric=metric,
        points=fields['points'].number(above=0) if 'points' in fields else 1.0,
        bounds=bounds,
        hint=' '.join(fields['hint'].text().split()) if 'hint' in fields else '',
        hidden='hidden' in fields and fields['hidden'].flag(),
        needs=_needed(fields['needs'], names) if 'needs' in fields else '',
    )
    if not criterion.name:
        name = f'{metric} {criterion.wanted}'
        criterion = replace(criterion, name=name)
    if criterion.name in names:
        raise entry.error(f"there are two criteria '{criterion.name}'; give one another name")
    return criterion


def _needed(entry: Entry, names: Sequence[str]) -> str:
    if entry.value not in names:
        known = ', '.join(f"'{name}'" for name in names)
        raise entry.mistake(f'the name of an earlier criterion{known and ": "}{known}')
    return entry.text()


def _metric(entry: Entry, fields: dict[str, Entry]) -> str:
    if 'metric' not in fields:
        raise entry.mistake('a criterion with a metric, such as metric: path_error')
    name = fields['metric'].text()
    return name if is_plugins(name) else fields['metric'].choice(FIGURES)


def _bounds(entry: Entry, fields: dict[str, Entry]) -> Bounds:
    given = [key for key in _BOUNDS if key in fields]
    if len(given) > 1:
        raise entry.error(
            f'this criterion has two bounds, {given[0]} and {given[1]}; leave one out, or write '
            'between: [low, high]'
        )
    if not given:
        raise entry.mistake(f'a criterion with one of {", ".join(_BOUNDS)}')
    [key] = given
    strict, none = key in ('below', 'above'), fields.get('none_at')
    if key == 'between':
        low, high = _pair(fields[key])
        below, above = _pair(none) if none else (low, high)
        if none and not below < low < high < above:
            raise none.mistake(f'a number below {low:g} and one above {high:g}')
        return Bounds(low, high, False, below if none else None, above if none else None)
    bound = fields[key].number()
    if key in ('at_most', 'below'):
        return Bounds(
            high=bound, strict=strict, none_above=none.number(above=bound) if none else None
        )
    none_below = none.number() if none else None
    if none and none_below is not None and none_below >= bound:
        raise none.mistake(f'a number below {bound:g}')
    return Bounds(low=bound, strict=strict, none_below=none_below)


def _pair(entry: Entry) -> tuple[float, float]:
    ends = [end.number() for end in entry.items()]
    if len(ends) != 2 or ends[0] >= ends[1]:
        raise entry.mistake('two numbers, the smaller one first, such as [0.4, 0.6]')
    return ends[0], ends[1]
