"""Criteria of a rubric, and the numbers of a run that they bound."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from setcmas_simu.option_kinds import Number, OneOf
from setcmas_simu.yaml_entries import Entry
from setcmas_tools.measures.metric import METRICS
from setcmas_tools.measures.metrics import measure
from setcmas_tools.run.run import Run
from setcmas_tools.study.study_columns import COLUMNS, SHIPPED, numbers_of

COMPARED = {
    'path_error': ('m', 'RMS distance to the paths of the solution, at equal times'),
    'end_error': ('m', 'largest distance from a final position of the solution'),
    'path_ratio': ('', 'total path length, divided by that of the solution'),
    'path_distance': (
        'm',
        'largest distance of a robot from the path of the solution, whatever the timing',
    ),
    'answer_error': (
        '',
        "relative difference between a law's results and those of the solution in the same places",
    ),
    'direction_error': (
        '°',
        "angle between a law's velocities and those of the solution in the same places; a robot "
        'that stands still, such as after an error, counts as 180°',
    ),
}
"""Comparisons with the model solution: units and descriptions."""

OF_ANSWERS = ('answer_error', 'direction_error')
"""Comparisons that need the solution itself, not only its run."""

UNITS = {
    **{name: column.unit for name, column in COLUMNS.items()},
    **{name: unit for name, (unit, _) in COMPARED.items()},
}
"""Units of all numbers, except those of plugins; '' for none."""

_SHARES = ('answer_error',)  # shown in percent
_LEAST = 1e-6  # smaller numbers are rounding errors
_LARGE = 1000  # from here on, numbers have no decimals


def quantity_text(number: float, metric: str) -> str:
    """Return a number with its unit; shares in percent."""
    unit = UNITS.get(metric, '')
    if metric in _SHARES:
        number, unit = 100 * number, '%'
    if abs(number) < _LEAST:
        number = 0.0
    return f'{number:{".0f" if abs(number) >= _LARGE else ".3g"}} {unit}'.rstrip()


def is_plugins(name: str) -> bool:
    """Return whether a name may be a column of a plugin's metric."""
    own = METRICS.plugins().keys() - SHIPPED - {'safety'}
    return any(name.startswith(one) for one in own)


def figures_of(run: Run) -> dict[str, float | None]:
    """Return the numbers of a run by name, None for missing ones; it has the references."""
    return numbers_of(measure(run, lambda _: None)) if len(run.counted.t) else {}


_BOUNDS = ('at_most', 'at_least', 'between')
_KEYS = ('name', 'metric', *_BOUNDS, 'none_at', 'points', 'hint', 'hidden', 'needs')
_CENTS = 100  # points have two decimals
_TINY = 1e-9


@dataclass(frozen=True)
class Bounds:
    """Wanted range of a number, and the limits of partial points.

    Attributes:
        low: Lower bound; -inf if there is none.
        high: Upper bound; inf if there is none.
        none_below: No points at this number and below; linear from here to `low`.
        none_above: No points at this number and above; linear from `high` to here.
    """

    low: float = -math.inf
    high: float = math.inf
    none_below: float | None = None
    none_above: float | None = None

    def share(self, number: float) -> float:
        """Return the share of the points for a number, from 0 to 1."""
        if self.low <= number <= self.high:
            return 1.0
        is_low = number < self.low
        none_at, bound = (self.none_below, self.low) if is_low else (self.none_above, self.high)
        if none_at is None or none_at == bound:
            return 0.0
        return max(0.0, (number - none_at) / (bound - none_at))

    def words(self, metric: str) -> str:
        """Return the bounds of a number as text, such as 'at most 0.05 m'."""
        low, high = (quantity_text(one, metric) for one in (self.low, self.high))
        if math.isfinite(self.low) and math.isfinite(self.high):
            return f'from {self.low:g} to {high}'
        if math.isfinite(self.low):
            return f'at least {low}'
        return f'at most {high}'


@dataclass(frozen=True)
class Criterion:
    """One condition on a run, and its points.

    Attributes:
        name: Description, unique in its scenario.
        metric: Name of the measured number: of `UNITS`, or of a plugin's metric.
        points: Points for a number within the bounds.
        hidden: Whether students only see its points.
        needs: Another criterion of the scenario; without its points this one gets none.
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
        """Unit of the number; '' if it has none."""
        return UNITS.get(self.metric, '')

    @property
    def wanted(self) -> str:
        """The bounds as text."""
        return self.bounds.words(self.metric)

    def points_for(self, number: float | None) -> float:
        """Return the points for a number, rounded to two decimals; 0 for no number."""
        if number is None or math.isnan(number):
            return 0.0
        return rounded(self.points * self.bounds.share(number))


def rounded(points: float) -> float:
    """Round points to two decimals, halves away from 0: 9.995 becomes 10."""
    cents = math.floor(abs(points) * _CENTS + 0.5 + 1e-6)
    return math.copysign(cents, points) / _CENTS if cents else 0.0


def points_text(points: float) -> str:
    """Return points with at most two decimals."""
    return f'{rounded(points):.2f}'.rstrip('0').rstrip('.')


def read_criteria(entry: Entry) -> tuple[Criterion, ...]:
    """Read the criteria in a list of a rubric.

    Raises:
        SetcmasError: The list is empty, or a criterion is invalid; the message has its line.
    """
    criteria: list[Criterion] = []
    for item in entry.items():
        criteria.append(_criterion(item, criteria))
    if not criteria:
        raise entry.mistake('a list with at least one criterion')
    return tuple(criteria)


def _criterion(entry: Entry, before: Sequence[Criterion]) -> Criterion:
    fields = entry.fields(_KEYS)
    metric = _metric(entry, fields)
    names = [one.name for one in before]
    bounds = _bounds(entry, fields)
    criterion = Criterion(
        name=fields['name'].text() if 'name' in fields else '',
        metric=metric,
        points=_points(fields['points']) if 'points' in fields else 1.0,
        bounds=bounds,
        hint=' '.join(fields['hint'].text().split()) if 'hint' in fields else '',
        hidden='hidden' in fields and fields['hidden'].flag(),
        needs=_needed(fields['needs'], names) if 'needs' in fields else '',
    )
    if not criterion.name:
        name = f'{metric} {criterion.wanted}'
        criterion = replace(criterion, name=name)
    if criterion.name in names:
        raise entry.error(f"two criteria are named '{criterion.name}'; rename one")
    return criterion


def _points(entry: Entry) -> float:
    """Return points in hundredths, so that those of all criteria add up to the shown total."""
    points = Number(above=0, finite=True).of(entry)
    if abs(rounded(points) - points) > _TINY:
        raise entry.mistake('a number with at most two decimals')
    return rounded(points)


def _needed(entry: Entry, names: Sequence[str]) -> str:
    if entry.value not in names:
        known = ', '.join(f"'{name}'" for name in names)
        raise entry.mistake(f'the name of an earlier criterion{known and ": "}{known}')
    return entry.text()


def _metric(entry: Entry, fields: dict[str, Entry]) -> str:
    if 'metric' not in fields:
        raise entry.mistake('a criterion with a metric, such as metric: path_error')
    name = fields['metric'].text()
    return name if is_plugins(name) else str(OneOf(tuple(UNITS)).of(fields['metric']))


def _bounds(entry: Entry, fields: dict[str, Entry]) -> Bounds:
    given = [key for key in _BOUNDS if key in fields]
    if len(given) > 1:
        raise entry.error(
            f'this criterion has two bounds, {given[0]} and {given[1]}; remove one, or write '
            'between: [low, high]'
        )
    if not given:
        raise entry.mistake(f'a criterion with one of {", ".join(_BOUNDS)}')
    [key] = given
    none = fields.get('none_at')
    if key == 'between':
        low, high = _pair(fields[key])
        below, above = _pair(none) if none else (None, None)
        if none and below is not None and above is not None and not below < low < high < above:
            raise none.mistake(f'a number below {low:g} and one above {high:g}')
        return Bounds(low, high, below, above)
    bound = fields[key].number()
    if key == 'at_most':
        return Bounds(high=bound, none_above=Number(above=bound).of(none) if none else None)
    none_below = none.number() if none else None
    if none and none_below is not None and none_below >= bound:
        raise none.mistake(f'a number below {bound:g}')
    return Bounds(low=bound, none_below=none_below)


def _pair(entry: Entry) -> tuple[float, float]:
    ends = [end.number() for end in entry.items()]
    if len(ends) != 2 or ends[0] >= ends[1]:
        raise entry.mistake('two numbers, the smaller one first, such as [0.4, 0.6]')
    return ends[0], ends[1]
