"""Plots over time: poses, velocities, distances, disagreement, errors, the filter."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
from matplotlib import rcParams
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator, NullFormatter

from setcmas_simu.fleet.palettes import plot_colour
from setcmas_tools.measures.agreement import disagreement, is_agreement
from setcmas_tools.measures.safety_metrics import distances_of_pairs
from setcmas_tools.measures.task_errors import errors_of
from setcmas_tools.plots import trajectories
from setcmas_tools.plots.plot import applies_to
from setcmas_tools.plots.reference_lines import draw_wanted_distances
from setcmas_tools.plots.style import drawn_robots, legend, line_handles, line_look, time_axis
from setcmas_tools.run.fleet_motion import FleetGrid, FleetTable
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_records import FilteredCommands


def draw_positions(figure: Figure, run: Run) -> None:
    """Draw x(t) and y(t), one above the other."""
    _draw_panels(figure, run.table, 'Positions', {'x': 'x (m)', 'y': 'y (m)'})


def draw_velocities(figure: Figure, run: Run) -> None:
    """Draw forward speed and turn rate over time, one above the other."""
    labels = {'v': 'forward speed v (m/s)', 'omega': 'turn rate ω (rad/s)'}
    _draw_panels(figure, run.table, 'Velocities', labels)


def draw_heading(figure: Figure, run: Run) -> None:
    """Draw unwrapped headings over time, so that lines have no artificial jumps."""
    figure.set_size_inches(9.0, 5.0)
    axes = figure.add_subplot(title='Heading (not wrapped)', ylabel='heading θ (rad)')
    trajectories.draw_robot_lines(axes, run.table, 'theta', np.unwrap)
    marks = time_axis([axes], run.table.t[0], run.table.t[-1])
    legend(axes, line_handles(run.robots) + marks)


def _draw_panels(figure: Figure, table: FleetTable, title: str, labels: dict[str, str]) -> None:
    figure.set_size_inches(9.0, 6.4)
    panels = figure.subplots(len(labels), sharex=True)
    for axes, (name, label) in zip(panels, labels.items(), strict=True):
        trajectories.draw_robot_lines(axes, table, name)
        axes.set_ylabel(label)
    figure.align_ylabels()
    panels[0].set_title(title)
    marks = time_axis(panels, table.t[0], table.t[-1])
    legend(panels[0], line_handles(table.robots) + marks)


@applies_to(lambda run: len(run.robots) > 1 and is_agreement(run))
def draw_disagreement(figure: Figure, run: Run) -> None:
    """Draw the disagreement on a log scale: exponential convergence is a straight line.

    Uses the disagreement of the metrics, so the line has their rate.
    """
    figure.set_size_inches(9.0, 5.0)
    axes = figure.add_subplot(title='Disagreement', ylabel=r'$|\delta|\, /\sqrt{N}$  (m)')
    axes.set_yscale('log')
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter('{x:g}')
    axes.yaxis.set_minor_formatter(NullFormatter())
    table, grid = run.table, run.grid()
    values = disagreement(grid.x, grid.y)
    values[~(values > 0)] = np.nan  # without logarithm
    # Matplotlib would warn of the limits of constant values.
    axes.plot(grid.t, values, color='0.15', scaley=False)
    if np.isfinite(values).any():
        axes.set_ylim(0.7 * np.nanmin(values), 1.4 * np.nanmax(values))
    legend(axes, time_axis([axes], table.t[0], table.t[-1]))


@applies_to(lambda run: errors_of(run) is not None)
def draw_errors(figure: Figure, run: Run) -> None:
    """Draw the distance of each robot from its reference or place over time."""
    errors = errors_of(run)
    assert errors
    figure.set_size_inches(9.0, 5.0)
    axes = figure.add_subplot(title=errors.title, ylabel=f'{errors.label} ({errors.unit})')
    t, robots = run.counted_grid.t, sorted(errors.values)
    curves = {robot: (t, errors.values[robot]) for robot in drawn_robots(robots)}
    trajectories.draw_curves(axes, curves, len(run.robots))
    axes.set_ylim(bottom=0.0)
    time_axis([axes], t[0], t[-1])
    legend(axes, line_handles(robots))


_LOOKS = {'changed': '0.75', 'no solution': '#d62728'}
_BAR = 0.7


@applies_to(lambda run: isinstance(run.commands, FilteredCommands))
def draw_filter(figure: Figure, run: Run) -> None:
    """Draw wanted and allowed speeds, and when the filter changed them."""
    figure.set_size_inches(9.0, 6.4)
    commands = run.commands
    assert isinstance(commands, FilteredCommands)
    speeds, verdicts = figure.subplots(2, sharex=True)
    for robot in drawn_robots(run.robots):
        own = commands.of(robot)
        _draw_speeds(speeds, own, robot, len(run.robots))
        _draw_verdicts(verdicts, own, robot)
    speeds.set_title('Wanted and allowed speed')
    speeds.set_ylabel('speed (m/s)')
    speeds.set_ylim(bottom=0.0)
    verdicts.set_ylabel('robot')
    verdicts.set_ylim(run.robots[-1] + 0.6, run.robots[0] - 0.6)
    if len(run.robots) <= 12:
        verdicts.set_yticks(run.robots)
    marks = time_axis([speeds, verdicts], run.table.t[0], run.table.t[-1])
    ways: list[Artist] = [
        Line2D([], [], label='wanted', color='0.4', linestyle=':'),
        Line2D([], [], label='allowed', color='0.4'),
    ]
    legend(speeds, [*line_handles(run.robots), *ways, *marks])
    legend(verdicts, [Patch(label=name, color=colour) for name, colour in _LOOKS.items()])
    figure.align_ylabels()


def _draw_speeds(axes: Axes, commands: FilteredCommands, robot: int, nb_robots: int) -> None:
    look = line_look(robot, nb_robots)
    wanted = np.hypot(commands.vx, commands.vy)
    axes.plot(commands.t, wanted, **{**look, 'linestyle': ':', 'path_effects': None})
    axes.plot(commands.t, np.hypot(commands.allowed_vx, commands.allowed_vy), **look)


def _draw_verdicts(axes: Axes, commands: FilteredCommands, robot: int) -> None:
    """Draw a bar over the times of each verdict, the worse one on top."""
    ends = np.append(commands.t[1:], commands.t[-1:])
    for held, colour in zip((commands.changed, commands.unsolved), _LOOKS.values(), strict=True):
        bars = list(zip(commands.t[held], (ends - commands.t)[held], strict=True))
        axes.broken_barh(bars, (robot - 0.5 * _BAR, _BAR), color=colour, linewidth=0)


_MOST_ROBOTS_IN_PAIRS = 5


@applies_to(lambda run: len(run.robots) > 1)
def draw_distances(figure: Figure, run: Run) -> None:
    """Draw the distance of each pair of robots; of more than 5, smallest, mean and largest."""
    table, grid = run.table, run.grid()
    figure.set_size_inches(9.0, 5.0)
    axes = figure.add_subplot(title='Distances between robots')
    draw = _draw_pairs if len(grid.robots) <= _MOST_ROBOTS_IN_PAIRS else _draw_range
    marks = time_axis([axes], table.t[0], table.t[-1])
    marks += draw_wanted_distances(axes, run)
    handles = draw(axes, grid)
    axes.set_ylim(bottom=0.0)
    legend(axes, handles + marks)


def _draw_pairs(axes: Axes, grid: FleetGrid) -> list[Artist]:
    width = rcParams['lines.linewidth']
    handles: list[Artist] = []
    for i, j in combinations(range(len(grid.robots)), 2):
        first, second = grid.robots[i], grid.robots[j]
        look: dict[str, Any] = {
            'color': plot_colour(first, len(grid.robots)),
            'gapcolor': plot_colour(second, len(grid.robots)),
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
