"""Figures of a run that rubrics may name: the columns of studies, and how near it is to another.

The other run is that of the model solution in the same scenario.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from setcmas_tools.comparison.repeat import distances_between
from setcmas_tools.kinds.metric import METRICS
from setcmas_tools.metrics.compute import measure
from setcmas_tools.records.fleet_grid import FleetGrid
from setcmas_tools.run.run import Run
from setcmas_tools.studies.columns import COLUMNS, SHIPPED, numbers_of

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
