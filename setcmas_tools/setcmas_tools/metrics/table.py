"""The table of a run's metrics for the terminal."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from tabulate import tabulate

from setcmas_simu.fleet.topics import robot_name
from setcmas_tools.kinds.metric import Columns, Measured

MOST_ROBOTS_IN_ROWS = 50
"""Of larger fleets the table shows the least, the mean and the largest values."""


def table_lines(parts: Mapping[str, Measured], task: str | None) -> list[str]:
    """Return metrics as lines of text: a row for each robot, then what concerns the fleet."""
    return [*robots_table(parts).splitlines(), *fleet_lines(parts, task)]


def fleet_lines(parts: Mapping[str, Measured], task: str | None) -> list[str]:
    """Return what concerns the fleet, in lines of text."""
    return [line for part in parts.values() for line in part.lines(task)]


def robots_table(parts: Mapping[str, Measured], form: str = 'simple') -> str:
    """Return a table with a row for each robot; empty if there is nothing of robots.

    Args:
        parts: What was measured.
        form: A format of tabulate, 'simple' or 'html', which is escaped.
    """
    columns = {name: c for part in parts.values() for name, c in part.columns().items()}
    return _robots_table(columns, form) if columns else ''


def _robots_table(columns: Columns, form: str) -> str:
    robots = sorted({robot for _, values in columns.values() for robot in values})
    if len(robots) <= MOST_ROBOTS_IN_ROWS:
        rows = [
            [
                robot_name(robot),
                *(_text(values.get(robot), form) for form, values in columns.values()),
            ]
            for robot in robots
        ]
    else:
        summaries: dict[str, Callable[[list[float]], float]] = {
            'least': min,
            'mean': lambda values: float(np.mean(values)),
            'largest': max,
        }
        rows = [
            [name, *(_text(_summary(values, of), form) for form, values in columns.values())]
            for name, of in summaries.items()
        ]
    headers = [f'{len(robots)}\nrobots' if len(rows) != len(robots) else 'robot']
    return tabulate(
        rows,
        [*headers, *columns],
        tablefmt=form,
        disable_numparse=True,
        colalign=('left', *['right'] * len(columns)),
    )


def _summary(
    values: Mapping[int, float | None], of: Callable[[list[float]], float]
) -> float | None:
    known = [value for value in values.values() if value is not None]
    return of(known) if known else None


def _text(value: float | None, form: str = '.2f') -> str:
    text = '-' if value is None else format(value, form)
    return text.lstrip('-') if text.startswith('-0') and not float(text) else text
