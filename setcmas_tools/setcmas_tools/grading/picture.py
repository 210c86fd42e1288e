"""Picture of the marks of a submission: its own paths over the wanted ones."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_tools.grading.marks import Marks, RobotPath, ScenarioMark
from setcmas_tools.plots.looks.style import (
    line_look,
    plot_style,
    robot_colour,
    robot_handles,
    save,
)
from setcmas_tools.plots.plot import show, window

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
    """See that a picture can be written to a file.

    Raises:
        SetcmasError: It cannot.
    """
    if path.suffix not in _SUFFIXES:
        raise SetcmasError(f"picture '{path}' must end with one of {', '.join(_SUFFIXES)}")
    if not path.parent.is_dir():
        raise SetcmasError(
            f"picture '{path}' cannot be written: there is no folder '{path.parent}'; create it"
        )


def write_picture(marks: Marks, path: Path, in_window: bool = False) -> None:
    """Write the picture of marks to a file.

    Args:
        marks: What is drawn.
        path: The file; its suffix, .png, .pdf or .svg, is the format.
        in_window: Whether to open it in a window as well.

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
    axes.set_title(f'{scenario.name}\n{scenario.points:g} of {scenario.max_points:g} points')
    axes.set(xlabel='x (m)', ylabel='y (m)')
    _fit(axes, scenario.paths)


def _draw_path(axes: Axes, path: RobotPath, nb_robots: int) -> None:
    wanted, own = _columns(path.wanted), _columns(path.own)
    axes.plot(*wanted, **_WANTED)
    axes.plot(*own, **line_look(path.robot, nb_robots))
    colour = robot_colour(path.robot, nb_robots)
    ring: dict[str, Any] = {'markerfacecolor': 'white', 'markeredgecolor': colour, 'markersize': 6}
    axes.plot(*own[:, :1], marker='o', linestyle='', zorder=3, **ring)
    axes.plot(*own[:, -1:], marker='o', linestyle='', zorder=4, color=colour, markersize=5)


def _fit(axes: Axes, paths: Sequence[RobotPath]) -> None:
    """Show the wanted paths with some room around, and so much of the own ones."""
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
