"""Pictures of a submission's paths and the solution's."""

from __future__ import annotations

import base64
import math
from collections.abc import Sequence
from importlib.resources import files
from itertools import groupby
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.palettes import plot_colour, plot_hex
from setcmas_tools.grade.marks import Marks, RobotPath, ScenarioMark
from setcmas_tools.plots.plot import show, window
from setcmas_tools.plots.style import line_look, plot_style, robot_handles, save

_PANEL_IN = 4.4  # width and height of a scenario's panel
_WANTED: dict[str, Any] = {'color': '0.72', 'linewidth': 5.0, 'zorder': 1.0}
_LEAST_SPAN_M = 1.0
_SUFFIXES = ('.png', '.pdf', '.svg')


def draw_marks(figure: Figure, marks: Marks) -> None:
    """Draw the paths of each scenario that has some, in panels side by side.

    Args:
        figure: An empty figure, made within `plot_style`.
        marks: What is drawn.
    """
    scenarios = [one for one in marks.scenarios if one.paths]
    figure.set_size_inches(_PANEL_IN * max(1, len(scenarios)) + 1.6, _PANEL_IN + 0.6)
    if not scenarios:
        return
    panels = figure.subplots(1, len(scenarios), squeeze=False)[0]
    for axes, scenario in zip(panels, scenarios, strict=True):
        _draw_scenario(axes, scenario)
    robots = sorted({path.robot for one in scenarios for path in one.paths})
    panels[-1].legend(
        handles=[Line2D([], [], label='wanted', **_WANTED), *robot_handles(robots)],
        loc='upper left', bbox_to_anchor=(1.02, 1.0), borderaxespad=0.0,
    )  # fmt: skip


def check_picture(path: Path) -> None:
    """Check that a picture can be written to a file.

    Raises:
        SetcmasError: It cannot.
    """
    if path.suffix not in _SUFFIXES:
        raise SetcmasError(f"picture '{path}' must end with one of {', '.join(_SUFFIXES)}")
    if not path.parent.is_dir():
        raise SetcmasError(
            f"picture '{path}' cannot be written: create folder '{path.parent}' first"
        )


def write_picture(marks: Marks, path: Path, in_window: bool = False) -> None:
    """Write the picture of marks to a file.

    Args:
        marks: What is drawn.
        path: The file; its suffix, .png, .pdf or .svg, is the format.
        in_window: Whether to open it in a window.

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
    axes.set_title(f'{scenario.name}\n{scenario.points_text}')
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


Points = Sequence[tuple[float, float]]

_SIZE = 360.0  # of the longer side, in units of the picture
_MARGIN = 30.0
_SMALLEST_SPAN_M = 1.0
_FARTHEST_M = 1e3  # a robot further away is not drawn
_STEPS = (1, 2, 5)


def path_picture(paths: Sequence[RobotPath], title: str) -> str:
    """Return a picture of paths as SVG; '' if there is nothing to draw.

    Args:
        paths: Paths of the robots.
        title: Description for screen readers.
    """
    drawn = [_Drawn(one) for one in paths]
    everything = [point for one in drawn for point in (*one.own, *one.wanted)]
    if not everything:
        return ''
    frame = _Frame(everything)
    lines = [frame.grid()]
    lines += [frame.line(one.wanted, 'class="wanted"') for one in drawn if one.wanted]
    lines += [
        frame.line(one.own, f'class="own" stroke="{one.colour}"') for one in drawn if one.own
    ]
    lines += [frame.ends(one) for one in drawn if one.own]
    return (
        f'<svg class="paths" viewBox="0 0 {frame.width:.1f} {frame.height:.1f}" role="img" '
        f'aria-label={quoteattr(title)}>{"".join(lines)}</svg>'
    )


def picture_address(paths: Sequence[RobotPath], title: str) -> str:
    """Return a picture of paths on white paper as the address of an image; '' if none."""
    picture = path_picture(paths, title)
    style = (files(__package__) / 'templates' / 'paths.css').read_text(encoding='utf-8')
    begin = (
        f'<svg xmlns="http://www.w3.org/2000/svg" style="background:#fff" width="480" '
        f'height="400"><style>{style}</style>'
    )
    encoded = base64.b64encode(f'{begin}{picture}</svg>'.encode()).decode()
    return f'data:image/svg+xml;base64,{encoded}' if picture else ''


class _Drawn:
    """The drawable part of a robot's path."""

    def __init__(self, path: RobotPath) -> None:
        self.robot, self.colour = path.robot, plot_hex(path.robot)
        self.own = _drawable(path.own)
        self.wanted = _drawable(path.wanted)


def _drawable(points: Points) -> Points:
    return [(x, y) for x, y in points if abs(x) < _FARTHEST_M and abs(y) < _FARTHEST_M]


class _Frame:
    """A part of the plane with equal scales, and its place in the picture."""

    def __init__(self, points: Points) -> None:
        xs, ys = zip(*points, strict=True)
        self._left, self._right = _span(min(xs), max(xs))
        self._bottom, self._top = _span(min(ys), max(ys))
        longer = max(self._right - self._left, self._top - self._bottom)
        self._scale = _SIZE / longer
        self.width = (self._right - self._left) * self._scale + 2 * _MARGIN
        self.height = (self._top - self._bottom) * self._scale + 2 * _MARGIN
        self._step = _step(longer)

    def _at(self, x: float, y: float) -> tuple[str, str]:
        right = _MARGIN + (x - self._left) * self._scale
        down = _MARGIN + (self._top - y) * self._scale
        return f'{right:.1f}', f'{down:.1f}'

    def line(self, points: Points, look: str) -> str:
        """Return a path; that of a robot that does not move is a dot."""
        places = (','.join(self._at(*point)) for point in points)
        moves = [place for place, _ in groupby(places)]
        moves += moves[-1:]  # a line of length 0 is drawn, a single point is not
        return f'<polyline {look} points="{" ".join(moves)}"/>'

    def ends(self, path: _Drawn) -> str:
        """Return a ring with the robot's number at the path's start, and a disc at its end."""
        (x0, y0), (x1, y1) = self._at(*path.own[0]), self._at(*path.own[-1])
        return (
            f'<circle class="end" fill="{path.colour}" cx="{x1}" cy="{y1}" r="4.5"/>'
            f'<circle class="start" stroke="{path.colour}" cx="{x0}" cy="{y0}" r="8"/>'
            f'<text class="robot" x="{x0}" y="{y0}" dy="3.5">{path.robot}</text>'
        )

    def grid(self) -> str:
        """Return grid lines at round numbers of m, with their numbers."""
        x0, y0 = self._at(self._left, self._bottom)
        x1, y1 = self._at(self._right, self._top)
        parts = []
        for value in _round_values(self._left, self._right, self._step):
            x, _ = self._at(value, 0)
            parts.append(
                f'<path d="M{x} {y0}V{y1}"/><text x="{x}" y="{y0}" dy="14">{value:g}</text>'
            )
        for value in _round_values(self._bottom, self._top, self._step):
            _, y = self._at(0, value)
            parts.append(
                f'<path d="M{x0} {y}H{x1}"/>'
                f'<text class="y" x="{x0}" y="{y}" dx="-5" dy="3.5">{value:g}</text>'
            )
        parts.append(f'<text class="axis" x="{x1}" y="{y0}" dy="26">x (m)</text>')
        parts.append(f'<text class="y axis" x="{x0}" y="{y1}" dx="8" dy="-9">y (m)</text>')
        return f'<g class="grid">{"".join(parts)}</g>'


def _span(low: float, high: float) -> tuple[float, float]:
    middle, half = (low + high) / 2, max(high - low, _SMALLEST_SPAN_M) * 0.56
    return middle - half, middle + half


def _step(span: float) -> float:
    """Return a round distance of grid lines, for 3 to 8 lines in a span."""
    power = 10.0 ** math.floor(math.log10(span / 3))
    return max(step * power for step in _STEPS if step * power <= span / 3)


def _round_values(low: float, high: float, step: float) -> list[float]:
    first, last = math.ceil(low / step), math.floor(high / step)
    return [round(number * step, 6) for number in range(first, last + 1)]
