"""Metrics: functions of a run, found by name, and their results."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from numbers import Real
from typing import TYPE_CHECKING, Any

from setcmas_simu.plugins import InvalidPluginError, PluginGroup, a_function

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


class Measured(dict[Any, Any]):
    """What a metric says of a run: values by name, for metrics.yaml; names end with their units.

    `measured.NAME` is short for `measured['NAME']`.

    Attributes:
        lines: Lines below the table.
        columns: Columns of the table with a value per robot.
    """

    def __init__(
        self, values: Mapping[Any, Any], lines: Sequence[str] = (), columns: Columns | None = None
    ) -> None:
        """Take values, and how the table shows them."""
        super().__init__(values)
        self.lines, self.columns = lines, columns or {}

    def __getattr__(self, name: str) -> Any:
        if name in self:
            return self[name]
        raise AttributeError(f'{type(self).__name__!r} has no value {name!r}')


class Value(Measured):
    """A number of the fleet or of each robot; `digits` decimals of it are in the table."""

    def __init__(
        self, name: str, value: float | Mapping[int, float], unit: str = '', digits: int = 2
    ) -> None:
        """Take a number; raise ValueError or TypeError if it cannot be shown."""
        form = f'.{digits}f'
        if isinstance(value, Mapping):
            for number in value.values():
                format(number, form)
            value = dict(value)
            columns = {f'{name}\n({unit})' if unit else name: (form, value)}
            super().__init__({'value': value, 'unit': unit}, columns=columns)
        else:
            line = f'{name}: {value:{form}} {unit}'.rstrip()
            super().__init__({'value': value, 'unit': unit}, [line])


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


METRICS: PluginGroup[Metric] = PluginGroup(
    'setcmas.metrics', 'metric', a_function('a function of a run')
)
"""Installed metrics."""
