"""Positions, headings and velocities of a fleet over time."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MultipleLocator

from setcmas_tools.plots.lines import draw_robot_lines
from setcmas_tools.plots.looks.style import legend, robot_handles, time_axis
from setcmas_tools.records.fleet_table import FleetTable
from setcmas_tools.run.run import Run

_MOST_TICKS = 9


def draw_positions(figure: Figure, run: Run) -> None:
    """Draw x(t) and y(t), one above the other."""
    _draw_panels(figure, run.table, 'Positions', {'x': 'x (m)', 'y': 'y (m)'})


def draw_velocities(figure: Figure, run: Run) -> None:
    """Draw forward speed and turn rate over time, one above the other."""
    labels = {'v': 'forward speed v (m/s)', 'omega': 'turn rate ω (rad/s)'}
    _draw_panels(figure, run.table, 'Velocities', labels)


def draw_heading(figure: Figure, run: Run) -> None:
    """Draw headings over time, not wrapped: a line has no jumps where its robot has none."""
    figure.set_size_inches(9.0, 5.0)
    axes = figure.add_subplot(title='Heading (not wrapped)', ylabel='heading θ (rad)')
    draw_robot_lines(axes, run.table, 'theta', np.unwrap)
    _ticks_in_pi(axes)
    marks = time_axis([axes], run.table.t[0], run.table.t[-1])
    legend(axes, robot_handles(run.robots) + marks)


def _draw_panels(figure: Figure, table: FleetTable, title: str, labels: dict[str, str]) -> None:
    figure.set_size_inches(9.0, 6.4)
    panels = figure.subplots(len(labels), sharex=True)
    for axes, (name, label) in zip(panels, labels.items(), strict=True):
        draw_robot_lines(axes, table, name)
        axes.set_ylabel(label)
    figure.align_ylabels()
    panels[0].set_title(title)
    marks = time_axis(panels, table.t[0], table.t[-1])
    legend(panels[0], robot_handles(table.robots) + marks)


def _ticks_in_pi(axes: Axes) -> None:
    low, high = axes.get_ylim()
    step = math.pi / 4
    while (high - low) / step > _MOST_TICKS:
        step *= 2
    axes.yaxis.set_major_locator(MultipleLocator(step))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: _in_pi(value)))


def _in_pi(value: float) -> str:
    quarters = round(value / (math.pi / 4))
    divisor = math.gcd(quarters, 4) or 4
    over, under = quarters // divisor, 4 // divisor
    factor = {1: '', -1: '−'}.get(over, str(over).replace('-', '−'))
    return f'{factor}π' + (f'/{under}' if under > 1 else '') if over else '0'
