"""Metrics: functions of a run, found by name, and their results."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from numbers import Real
from typing import TYPE_CHECKING, Any

from setcmas_simu.plugins import InvalidPluginError, PluginGroup

if TYPE_CHECKING:
    from setcmas_tools.run.run import Run

Columns = Mapping[str, tuple[str, Mapping[int, float | None]]]
"""Columns of the table by header: format and values by robot."""


_UNITS = {
    '1_s': '1/s', 'm_s': 'm/s', 'm': 'm', 'rad_s': 'rad/s', 's': 's', 'rad': 'rad', 'percent': '%',
}  # fmt: skip


def words_and_unit(field: str) -> tuple[str, str]:
    """Return a field's name in words, and its unit, '' if it has none, for texts and labels."""
    ending = next((one for one in _UNITS if field.endswith(f'_{one}')), '')
    return field.removesuffix(f'_{ending}').replace('_', ' '), _UNITS.get(ending, '')


class Measured:
    """One kind of measurement of a run: a dataclass whose field names end with their units."""

    def columns(self) -> Columns:
        """Return the table's columns with a value per robot."""
        return {}

    def lines(self) -> list[str]:
        """Return the lines below the table."""
        return []

    def as_dict(self) -> dict[str, Any]:
        """Return the values by name, for metrics.yaml."""
        return asdict(self)  # type: ignore[call-overload, no-any-return]


@dataclass(frozen=True)
class Value(Measured):
    """A number of the fleet or of each robot; `digits` decimals of it are in the table."""

    name: str
    value: float | Mapping[int, float]
    unit: str = ''
    digits: int = 2

    def __post_init__(self) -> None:
        """Check that a number can be shown; ValueError or TypeError otherwise."""
        values = self.value.values() if isinstance(self.value, Mapping) else [self.value]
        for value in values:
            format(value, f'.{self.digits}f')

    def columns(self) -> Columns:
        """Return a column if there is a number for each robot."""
        if not isinstance(self.value, Mapping):
            return {}
        unit = f'\n({self.unit})' if self.unit else ''
        return {f'{self.name}{unit}': (f'.{self.digits}f', self.value)}

    def lines(self) -> list[str]:
        """Return a line if there is a single number."""
        if isinstance(self.value, Mapping):
            return []
        return [f'{self.name}: {self.value:.{self.digits}f} {self.unit}'.rstrip()]

    def as_dict(self) -> dict[str, Any]:
        """Return the number, or the numbers by robot."""
        value = dict(self.value) if isinstance(self.value, Mapping) else self.value
        return {'value': value, 'unit': self.unit}


Metric = Callable[['Run'], Measured | float | None]
"""Measures a run; returns None if it does not apply."""


def measured(name: str, result: object) -> Measured | None:
    """Return the result of a metric as a measurement; a number becomes a `Value`.

    Raises:
        InvalidPluginError: It is something else.
    """
    if isinstance(result, Real) and not isinstance(result, bool):
        return Value(name, float(result))
    if result is None or isinstance(result, Measured):
        return result
    raise InvalidPluginError(
        f'returned a value of type {type(result).__name__}; it must return a number, a Value of '
        'a number or of numbers by robot, or None'
    )


def _metric(thing: object) -> Metric:
    if not callable(thing):
        raise InvalidPluginError(f'it is a {type(thing).__name__}; it must be a function of a run')
    return thing


METRICS = PluginGroup('setcmas.metrics', 'metric', _metric)
"""Installed metrics."""
