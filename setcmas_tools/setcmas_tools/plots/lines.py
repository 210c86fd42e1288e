"""Lines over the samples of robots, without lines across gaps in the data."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes

from setcmas_simu.arrays import Floats
from setcmas_tools.plots.looks.style import line_look
from setcmas_tools.records.fleet_grid import LONGEST_GAP_S
from setcmas_tools.records.fleet_table import FleetTable


def with_gaps(t: Floats, *columns: Floats) -> list[Floats]:
    """Return times and columns with a NaN in each gap, at which plotted lines break."""
    gaps = np.flatnonzero(np.diff(t) > LONGEST_GAP_S) + 1
    return [np.insert(column, gaps, np.nan) for column in (t, *columns)]


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
    robots = table.robots
    for robot in robots:
        rows = finite_rows(table.of(robot), name)
        values = getattr(rows, name)
        t, values = with_gaps(rows.t, change(values) if change else values)
        axes.plot(t, values, **line_look(robot, len(robots)))
