"""The trajectories of a fleet in the plane."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.markers import MarkerStyle
from matplotlib.transforms import Affine2D

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.fleet import Colour
from setcmas_simu.robots.models import UNICYCLE
from setcmas_tools.plots.drawings import DrawnPlane
from setcmas_tools.plots.lines import finite_rows, with_gaps
from setcmas_tools.plots.looks.style import (
    edge_effects,
    legend,
    line_look,
    robot_colour,
    robot_handles,
)
from setcmas_tools.plots.references import draw_references, draw_world
from setcmas_tools.plots.robot_symbols import closed, symbol, symbols
from setcmas_tools.records.fleet_table import FleetTable
from setcmas_tools.run.run import Run

_SMALLEST_SPAN_M = 1.0


def draw_trajectories(figure: Figure, run: Run) -> None:
    """Draw each robot's path with its start (ring) and its end (dart along its heading)."""
    figure.set_size_inches(8.0, 6.4)
    axes = figure.add_subplot()
    table, robots = run.table, run.robots
    size = rcParams['lines.markersize'] * (1.5 if len(robots) < 12 else 1.1)
    looks = symbols(run)
    for robot in robots:
        _draw_path(axes, table.of(robot), robot, len(robots), size)
        _draw_end(axes, table.of(robot), robot_colour(robot, len(robots)), size, looks[robot])
    drawn = DrawnPlane(axes, run)
    drawn.show(np.inf)
    marks = draw_references('trajectories', axes, run) + draw_world(axes, run) + drawn.handles
    axes.set_title('Trajectories')
    fit_plane(axes, table)
    legend(axes, [*robot_handles(robots), *_end_handles(), *marks])


def _draw_path(axes: Axes, path: FleetTable, robot: int, nb_robots: int, size: float) -> None:
    path = finite_rows(path, 'x', 'y', 'theta')
    if not len(path.t):
        return
    x, y = with_gaps(path, path.x, path.y)
    axes.plot(x, y, **line_look(robot, nb_robots))
    colour = robot_colour(robot, nb_robots)
    axes.plot(
        path.x[:1], path.y[:1], marker='o', markersize=size * 0.8, markerfacecolor='white',
        markeredgecolor=colour, markeredgewidth=size / 5, linestyle='', zorder=3,
        path_effects=edge_effects(colour, size / 5),
    )  # fmt: skip


def _draw_end(axes: Axes, path: FleetTable, colour: Colour, size: float, corners: Floats) -> None:
    path = finite_rows(path, 'x', 'y', 'theta')
    heading = Affine2D().rotate(math.fmod(path.theta[-1], math.tau)) if len(path.t) else None
    axes.plot(
        path.x[-1:], path.y[-1:], marker=MarkerStyle(closed(corners), transform=heading),
        markersize=size * float(np.abs(corners).max()), markerfacecolor=colour, zorder=4,
        markeredgecolor='0.15', markeredgewidth=size / 11, linestyle='',
    )  # fmt: skip


def fit_plane(axes: Axes, table: FleetTable) -> None:
    """Show all positions of a fleet with equal scales, and a plane of some size at least.

    A robot that hardly moves does not fill the plot with its noise.
    """
    rows = finite_rows(table, 'x', 'y')
    if len(rows.t):
        axes.update_datalim(np.column_stack([rows.x, rows.y]))
    middle = (axes.dataLim.p0 + axes.dataLim.p1) / 2
    axes.update_datalim([middle - _SMALLEST_SPAN_M / 2, middle + _SMALLEST_SPAN_M / 2])
    axes.set(xlabel='x (m)', ylabel='y (m)')
    axes.margins(0.06)
    axes.autoscale_view()
    axes.set_aspect('equal', adjustable='datalim')


def _end_handles() -> list[Line2D]:
    size = 1.3 * rcParams['lines.markersize']
    look: dict[str, Any] = {
        'linestyle': '',
        'markersize': size,
        'markeredgecolor': '0.15',
        'markeredgewidth': size / 11,
    }
    return [
        Line2D([], [], label='start', marker='o', markerfacecolor='white', **look),
        Line2D(
            [],
            [],
            label='end, heading',
            marker=MarkerStyle(closed(symbol(UNICYCLE))),
            color='0.6',
            **look,
        ),
    ]
