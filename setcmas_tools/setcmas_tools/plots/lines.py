"""Lines over the samples of robots, without lines across gaps in the data."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from setcmas_simu.arrays import Floats
from setcmas_tools.plots.looks.style import line_look
from setcmas_tools.records.fleet_table import FleetTable
from setcmas_tools.records.gaps import gaps

_NEAR = 0.005  # of what all curves span
_DASH = 4.0  # in widths of the line


def with_gaps(track: FleetTable, *columns: Floats) -> list[Floats]:
    """Return columns beside the rows of one robot with a NaN in each gap, where lines break."""
    breaks = np.flatnonzero(gaps(track)) + 1
    return [np.insert(column, breaks, np.nan) for column in columns]


def finite_rows(table: FleetTable, *names: str) -> FleetTable:
    """Return the rows in which the named columns are all finite."""
    columns = np.array([getattr(table, name) for name in names])
    return table.rows(np.isfinite(columns).all(axis=0))


def draw_robot_lines(
    axes: Axes, table: FleetTable, name: str, change: Callable[[Floats], Floats] | None = None
) -> None:
    """Draw one column of a table over time, a line for each robot.

    Args:
        axes: Where to draw.
        table: The fleet's motion.
        name: Name of the column.
        change: Applied to each robot's values before they are drawn.
    """
    curves = {}
    for robot in table.robots:
        rows = finite_rows(table.of(robot), name)
        values = getattr(rows, name)
        curves[robot] = with_gaps(rows, rows.t, change(values) if change else values)
    shared = shared_dashes([(t, values) for t, values in curves.values()])
    for (robot, (t, values)), dashes in zip(curves.items(), shared, strict=True):
        axes.plot(t, values, **line_look(robot, len(curves)) | dashes)


def shared_dashes(curves: Sequence[tuple[Floats, Floats]]) -> list[dict[str, Any]]:
    """Return the line styles of curves: those that lie on each other show in turn, in dashes.

    Args:
        curves: Times and values of each, with NaN where there is a gap.

    Returns:
        Keywords for each curve, none for one that lies alone.
    """
    known = np.concatenate([values for _, values in curves])
    near = _NEAR * float(np.ptp(known[np.isfinite(known)])) if np.isfinite(known).any() else 0.0
    groups: list[list[int]] = []
    for number, curve in enumerate(curves):
        same = [group for group in groups if _coincide(curves[group[0]], curve, near)]
        if same:
            same[0].append(number)
        else:
            groups.append([number])
    looks: list[dict[str, Any]] = [{} for _ in curves]
    for group in groups:
        for place, number in enumerate(group if len(group) > 1 else []):
            off = _DASH * (len(group) - 1)
            looks[number] = {'linestyle': (off + _DASH - _DASH * place, (_DASH, off))}
    return looks


def _coincide(one: tuple[Floats, Floats], other: tuple[Floats, Floats], near: float) -> bool:
    """Return whether two curves are nowhere farther apart than that."""
    (t, values), (u, others) = one, other
    if len(t) < 2 or len(u) < 2:
        return False
    return float(np.nan_to_num(np.abs(np.interp(t, u, others) - values)).max()) <= near
