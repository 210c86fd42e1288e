"""Distances between the robots of a fleet over time."""

from __future__ import annotations

import warnings
from itertools import combinations
from typing import Any

import numpy as np
from matplotlib import rcParams
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from setcmas_tools.kinds.plot import applies_to
from setcmas_tools.metrics.separation import distances_of_pairs
from setcmas_tools.plots.looks.style import (
    legend,
    line_look,
    robot_colour,
    robot_handles,
    time_axis,
)
from setcmas_tools.plots.references import draw_references
from setcmas_tools.records.fleet_grid import FleetGrid
from setcmas_tools.run.run import Run

_MOST_ROBOTS_IN_PAIRS = 5


@applies_to(lambda run: len(run.robots) > 1)
def draw_distances(figure: Figure, run: Run) -> None:
    """Draw the distance of each pair of robots; of many robots, what summarises them.

    Fleets of more than 5 get the smallest, mean and largest distance of all pairs, and below it
    the distance of each robot to the centre of the fleet.
    """
    table, grid = run.table, run.grid()
    if len(grid.robots) <= _MOST_ROBOTS_IN_PAIRS:
        figure.set_size_inches(9.0, 5.0)
        panels, draws = [figure.add_subplot()], [_draw_pairs]
    else:
        figure.set_size_inches(9.0, 6.4)
        panels, draws = list(figure.subplots(2, sharex=True)), [_draw_range, _draw_to_centre]
    marks = time_axis(panels, table.t[0], table.t[-1])
    marks += draw_references('distances', panels[0], run)
    for axes, draw in zip(panels, draws, strict=True):
        handles = draw(axes, grid)
        axes.set_ylim(bottom=0.0)
        legend(axes, handles + marks)
        marks = []
    panels[0].set_title('Distances between robots')
    figure.align_ylabels()


def _draw_pairs(axes: Axes, grid: FleetGrid) -> list[Artist]:
    width = rcParams['lines.linewidth']
    handles: list[Artist] = []
    for i, j in combinations(range(len(grid.robots)), 2):
        first, second = grid.robots[i], grid.robots[j]
        look: dict[str, Any] = {
            'color': robot_colour(first, len(grid.robots)),
            'gapcolor': robot_colour(second, len(grid.robots)),
            'linestyle': (0, (5, 5)),
            'linewidth': 1.25 * width,
        }
        distance = np.hypot(grid.x[i] - grid.x[j], grid.y[i] - grid.y[j])
        axes.plot(grid.t, distance, color='0.25', linewidth=1.8 * width)
        axes.plot(grid.t, distance, **look)
        handles.append(Line2D([], [], label=f'robots {first} and {second}', **look))
    axes.set_ylabel('distance (m)')
    return handles


def _draw_range(axes: Axes, grid: FleetGrid) -> list[Artist]:
    smallest, mean, largest = distances_of_pairs(grid)
    axes.fill_between(grid.t, smallest, largest, color='0.88', linewidth=0)
    (low,) = axes.plot(grid.t, smallest, color='0.2', linestyle=':', label='smallest')
    (middle,) = axes.plot(grid.t, mean, color='0.2', label='mean')
    (high,) = axes.plot(grid.t, largest, color='0.2', linestyle='--', label='largest')
    axes.set_ylabel('distance of pairs (m)')
    return [high, middle, low]


def _draw_to_centre(axes: Axes, grid: FleetGrid) -> list[Artist]:
    with warnings.catch_warnings():
        warnings.simplefilter('ignore', RuntimeWarning)  # times at which no robot has a pose
        centre = np.nanmean([grid.x, grid.y], axis=1)
    centre[:, ~grid.complete] = np.nan
    for robot, x, y in zip(grid.robots, grid.x, grid.y, strict=True):
        distance = np.hypot(x - centre[0], y - centre[1])
        axes.plot(grid.t, distance, **line_look(robot, len(grid.robots)))
    axes.set_ylabel('distance to centre (m)')
    return robot_handles(grid.robots)
