"""Pictures of a submission's paths and the solution's."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.palettes import plot_colour, plot_hex
from setcmas_tools.grade.marks import Marks, RobotPath, ScenarioMark
from setcmas_tools.plots.plot import show, window
from setcmas_tools.plots.style import as_written, line_look, plot_style, robot_handles, save

_PANEL_IN = 4.4  # width and height of a scenario's panel
_PANELS = 2  # in a row: more are too small on a page and on a slide
_WANTED: dict[str, Any] = {'color': '0.72', 'linewidth': 5.0, 'zorder': 1.0}
_LEAST_SPAN_M = 1.0
_SUFFIXES = ('.png', '.pdf', '.svg')


def draw_marks(figure: Figure, marks: Marks) -> None:
    """Draw the paths of each scenario that has some, two panels side by side.

    The figure is empty, and was made within `plot_style`.
    """
    scenarios = [one for one in marks.scenarios if one.paths]
    columns, rows = min(_PANELS, len(scenarios)) or 1, math.ceil(len(scenarios) / _PANELS) or 1
    figure.set_size_inches(_PANEL_IN * columns + 1.6, (_PANEL_IN + 0.6) * rows)
    if not scenarios:
        return
    panels = [figure.add_subplot(rows, columns, 1 + k) for k in range(len(scenarios))]
    for axes, scenario in zip(panels, scenarios, strict=True):
        _draw_scenario(axes, scenario)
    robots = sorted({path.robot for one in scenarios for path in one.paths})
    panels[columns - 1].legend(
        handles=[Line2D([], [], label='wanted', **_WANTED), *robot_handles(robots)],
        loc='upper left', bbox_to_anchor=(1.02, 1.0), borderaxespad=0.0,
    )  # fmt: skip


def check_picture(path: Path) -> None:
    """Check that a picture can be written to a file; raise SetcmasError otherwise."""
    if path.suffix not in _SUFFIXES:
        raise SetcmasError(f"picture '{path}' must end with one of {', '.join(_SUFFIXES)}")
    if not path.parent.is_dir():
        raise SetcmasError(
            f"picture '{path}' cannot be written: create folder '{path.parent}' first"
        )


def write_picture(marks: Marks, path: Path, in_window: bool = False) -> None:
    """Write the picture of marks to a file, and perhaps show it in a window.

    Raises:
        SetcmasError: It cannot be written, or there is no screen.
    """
    with plot_style():
        figure = window() if in_window else Figure()
        draw_marks(figure, marks)
        try:
            save(figure, path)
        except (OSError, ValueError) as error:
            raise SetcmasError(f"picture '{path}' cannot be written: {error}") from error
        if in_window:
            show(path.parent)


def _draw_scenario(axes: Axes, scenario: ScenarioMark) -> None:
    for path in scenario.paths:
        _draw_path(axes, path, len(scenario.paths))
    axes.set_title(as_written(f'{scenario.name}\n{scenario.points_text}'))
    axes.set(xlabel='x (m)', ylabel='y (m)')
    _fit(axes, scenario.paths)


def _draw_path(axes: Axes, path: RobotPath, nb_robots: int) -> None:
    wanted, own = _columns(path.wanted), _columns(path.own)
    axes.plot(*wanted, **_WANTED)
    axes.plot(*own, **line_look(path.robot, nb_robots))
    colour = plot_colour(path.robot, nb_robots)
    ring: dict[str, Any] = {'markerfacecolor': 'white', 'markeredgecolor': colour, 'markersize': 6}
    axes.plot(*own[:, :1], marker='o', linestyle='', zorder=3, **ring)
    axes.plot(*own[:, -1:], marker='o', linestyle='', zorder=4, color=colour, markersize=5)


def _fit(axes: Axes, paths: Sequence[RobotPath]) -> None:
    """Show the reference paths with a margin, and as much as possible of the own paths."""
    points = np.hstack([_columns(path.wanted or path.own) for path in paths])
    if not points.size:
        return
    low, high = points.min(axis=1), points.max(axis=1)
    span = max(float((high - low).max()), _LEAST_SPAN_M)
    middle, half = (low + high) / 2, 0.65 * span
    axes.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half))
    axes.set_aspect('equal')


def _columns(points: Sequence[tuple[float, float]]) -> Floats:
    columns: Floats = np.array(points, dtype=float).reshape(-1, 2).T
    return columns


_SIZE = 360.0  # of the longer side, in units of the picture
_MARGIN = 30.0
_FARTHEST_M = 1e3  # a robot further away is not drawn
_MOST_LINES = 7  # of the grid, along a side


def path_picture(paths: Sequence[RobotPath], title: str) -> str:
    """Return a picture of paths as SVG for a page; '' if there is nothing to draw.

    It takes 5 ms, a figure of matplotlib 50 ms, and a class has hundreds. Screen readers read
    the title.
    """
    drawn = [(path.robot, _near(path.own), _near(path.wanted)) for path in paths]
    points = np.concatenate([np.empty((0, 2)), *(one for _, *each in drawn for one in each)])
    if not len(points):
        return ''
    middle, span = (points.max(0) + points.min(0)) / 2, np.ptp(points, axis=0)
    low = middle - 0.56 * np.maximum(span, _LEAST_SPAN_M)
    high = 2 * middle - low
    scale = np.array([1.0, -1.0]) * _SIZE / max(high - low)

    def placed(points: Floats) -> Floats:
        placed: Floats = _MARGIN + (points - [low[0], high[1]]) * scale
        return placed

    width, height = placed(np.array([high[0], low[1]])) + _MARGIN
    lines = [_grid(placed, low, high)]
    lines += [_line(placed(wanted), 'class="wanted"') for *_, wanted in drawn if len(wanted)]
    lines += [_robot(robot, placed(own)) for robot, own, _ in drawn if len(own)]
    return (
        f'<svg class="paths" viewBox="0 0 {width:.1f} {height:.1f}" role="img" '
        f'aria-label={quoteattr(title)}>{"".join(lines)}</svg>'
    )


def _near(points: Sequence[tuple[float, float]]) -> Floats:
    """Return the points that can be drawn, shape (K, 2)."""
    found = _columns(points).T
    near: Floats = found[(np.abs(found) < _FARTHEST_M).all(axis=1)]
    return near


def _line(points: Floats, look: str) -> str:
    """Return a path; that of a robot that does not move is a dot."""
    places = [f'{x:.1f},{y:.1f}' for x, y in points]
    moves = [place for place, _ in groupby(places)]
    moves += moves[-1:]  # a line of length 0 is drawn, a single point is not
    return f'<polyline {look} points="{" ".join(moves)}"/>'


def _robot(robot: int, own: Floats) -> str:
    """Return a path with a ring and the robot's number at its start, and a disc at its end."""
    (x0, y0), (x1, y1), colour = own[0], own[-1], plot_hex(robot)
    line = _line(own, f'class="own" stroke="{colour}"')
    return (
        f'{line}'
        f'<circle class="end" fill="{colour}" cx="{x1:.1f}" cy="{y1:.1f}" r="4.5"/>'
        f'<circle class="start" stroke="{colour}" cx="{x0:.1f}" cy="{y0:.1f}" r="8"/>'
        f'<text class="robot" x="{x0:.1f}" y="{y0:.1f}" dy="3.5">{robot}</text>'
    )


def _grid(placed: Callable[[Floats], Floats], low: Floats, high: Floats) -> str:
    """Return grid lines at round numbers of m, with their numbers."""
    (left, bottom), (right, top) = placed(np.array([low, high])).round(1).tolist()
    step = np.diff(MaxNLocator(_MOST_LINES).tick_values(0.0, max(high - low)))[0]
    parts = []
    for axis in (0, 1):
        for value in step * np.arange(np.ceil(low[axis] / step), high[axis] / step):
            x, y = placed(np.array([value, value])).round(1).tolist()
            line = f'M{left} {y}H{right}' if axis else f'M{x} {bottom}V{top}'
            place = f'class="y" x="{left}" y="{y}"' if axis else f'x="{x}" y="{bottom}" dy="14"'
            parts.append(f'<path d="{line}"/><text {place}>{value:g}</text>')
    return (
        f'<g class="grid">{"".join(parts)}<text class="axis" x="{right}" y="{bottom}" dy="26">'
        f'x (m)</text><text class="axis" x="{left}" y="{top}" dx="20" dy="-9">y (m)</text></g>'
    )
