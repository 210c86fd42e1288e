"""Columns of a study's table: short names for metrics, and the study's own metrics."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Any

import numpy as np

from setcmas_simu.errors import SetcmasError, did_you_mean
from setcmas_tools.measures.metric import METRICS, Measured, words_and_unit
from setcmas_tools.measures.metrics import PREDICTION

_DIGITS = 9


def _mean_number(lists: list[Any]) -> Any:
    """Return how many elements lists have, on average."""
    return np.mean([len(one) for one in lists])


@dataclass(frozen=True)
class Column:
    """A number that describes a run.

    Attributes:
        purpose: What it is.
        metric: The metric that has it.
        field: Its field of that metric, which ends with its unit.
        over_robots: Combines values of robots, if there is one per robot.
        endless: Whether a run without it counts as infinite, such as a time never reached.
    """

    purpose: str
    metric: str
    field: str
    over_robots: Callable[[list[Any]], Any] | None = None
    endless: bool = False

    @property
    def unit(self) -> str:
        """Its unit; '' if it has none."""
        return '' if self.over_robots is _mean_number else words_and_unit(self.field)[1]

    def number_in(self, metrics: Mapping[str, Measured]) -> float | None:
        """Return the number of a run; None if it has none."""
        values = metrics[self.metric]
        if not self.over_robots:
            return values[self.field]  # type: ignore[no-any-return]
        is_there = self.field in values  # else each robot has it
        by_robot = values[self.field] if is_there else values
        numbers = [one if is_there else one[self.field] for one in by_robot.values()]
        known = [number for number in numbers if number is not None]
        return float(self.over_robots(known)) if known else None


COLUMNS = {
    'disagreement': Column(
        'RMS distance to the centre, at the end', 'consensus', 'disagreement_at_end_m'
    ),
    'disagreement_rms': Column(
        'RMS distance to the centre over the second half', 'consensus',
        'disagreement_rms_second_half_m',
    ),
    'settling_time': Column(
        'time from which disagreement stays below 5 %', 'consensus', 'settling_time_5_percent_s',
        endless=True,
    ),
    'settling_time_2': Column(
        'time from which disagreement stays below 2 %', 'consensus', 'settling_time_2_percent_s',
        endless=True,
    ),
    'convergence_rate': Column(
        'decay rate of the disagreement, from 20 % to 2 %', 'consensus', 'convergence_rate_1_s'
    ),
    'least_separation': Column(
        'smallest distance between two robots', 'separation', 'least_separation_m'
    ),
    'collisions': Column('pairs of robots that touched', 'separation', 'pairs_that_touched'),
    'largest_distance': Column(
        'largest distance between two robots at the end', 'separation',
        'largest_distance_at_end_m',
    ),
    'path_length': Column('mean over the robots', 'robots', 'path_length_m', np.mean),
    'mean_speed': Column('mean over the robots', 'robots', 'mean_speed_m_s', np.mean),
    'largest_speed': Column('largest speed of all robots', 'robots', 'largest_speed_m_s', np.max),
    'saturation': Column(
        'time saturated at the speed limit, mean over the robots', 'robots',
        'time_in_saturation_s', np.mean,
    ),
    'dead_band': Column(
        'time below 0.01 m/s, mean over the robots', 'robots', 'time_in_dead_band_s', np.mean
    ),
    'communications': Column('states sent by all robots', 'robots', 'communications', np.sum),
    'received': Column('messages that arrived', 'messages', 'received'),
    'lost': Column('messages that were lost', 'messages', 'lost'),
    'broken_links': Column('times that a link ended', 'messages', 'broken_links'),
    'agreement_time': Column(
        'time from which all laws send the same value', 'messages', 'agreement_time_s',
        endless=True,
    ),
    'position_error': Column(
        'formation: RMS over the last 25 %', 'formation', 'fleet_position_error_rms_last_quarter_m'
    ),
    'distance_error': Column(
        'distances: RMS over the last 25 %', 'distances', 'distance_error_rms_last_quarter_m'
    ),
    'tracking_error': Column(
        'tracking: RMS over the second half', 'tracking', 'fleet_tracking_error_rms_second_half_m'
    ),
    'waypoints_reached': Column(
        'waypoints reached, mean over the robots', 'waypoints', 'reached_at_s', _mean_number
    ),
}  # fmt: skip
"""Columns of built-in metrics; those of plugins are named METRIC_FIELD."""

OUTCOME = ('state', 'robots', 'message')
"""Columns with the outcome of a run."""

SHIPPED = {column.metric for column in COLUMNS.values()}
"""The built-in metrics."""


def numbers_of(metrics: Mapping[str, Measured]) -> dict[str, float | None]:
    """Return the metrics of a run by column, with 9 digits."""
    found = {
        name: column.number_in(metrics)
        for name, column in COLUMNS.items()
        if column.metric in metrics
    }
    for metric, part in metrics.items():
        if metric not in (*SHIPPED, PREDICTION):
            found |= _others(metric, part)
    return {name: _rounded(number) for name, number in found.items()}


def _others(metric: str, values: Mapping[Any, Any]) -> dict[str, float | None]:
    """Return the numbers of a plugin's metric; means of values by robot."""
    found: dict[str, float | None] = {}
    for field, value in values.items():
        name = metric if field == 'value' else f'{metric}_{field}'
        if isinstance(value, Real) and not isinstance(value, bool):
            found[name] = float(value)
        elif isinstance(value, Mapping) and all(isinstance(one, Real) for one in value.values()):
            found[name] = float(np.mean(list(value.values()))) if value else None
    return found


def _rounded(number: float | None) -> float | None:
    if number is None or not np.isfinite(number):
        return None
    return float(f'{number:.{_DIGITS}g}') + 0.0  # + 0.0: no minus before zero


def check_known(names: Sequence[str]) -> None:
    """Check that metrics are columns of a study, or raise SetcmasError."""
    of_plugins = tuple(name for name in METRICS.plugins() if name not in SHIPPED)
    for name in names:
        if name not in COLUMNS and not name.startswith(of_plugins):
            raise SetcmasError(
                f"--metric '{name}': unknown column; must be one of {', '.join(COLUMNS)}"
                f'{did_you_mean(name, COLUMNS, 2)}'
            )
