"""Pictures of a submission's paths over those of the solution."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_tools.grade.mark_records import RobotPath, ScenarioMark
from setcmas_tools.plots.plot import show, window
from setcmas_tools.plots.style import (
    as_written,
    data_url,
    line_look,
    plot_style,
    png,
    robot_handles,
    save,
)

_PANEL_IN = 4.4  # width and height of a scenario's panel
_PANELS = 2  # in a row: more are too small on a page and on a slide
_WANTED: dict[str, Any] = {'color': '0.72', 'linewidth': 5.0, 'zorder': 1.0}
_LEAST_SPAN_M = 1.0


def draw_marks(figure: Figure, marks: Sequence[ScenarioMark]) -> None:
    """Draw the paths of each scenario that has some, two panels side by side.

    The figure is empty, and was made within `plot_style`.
    """
    scenarios = [one for one in marks if one.paths]
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


def write_picture(marks: Sequence[ScenarioMark], path: Path, in_window: bool = False) -> None:
    """Write the picture of scenarios to a file, and perhaps show it in a window.

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


def picture_url(marks: Sequence[ScenarioMark], dpi: int) -> str:
    """Return the picture of scenarios as the data URL of a PNG; '' if none has paths."""
    if not any(one.paths for one in marks):
        return ''
    with plot_style():
        figure = Figure()
        draw_marks(figure, marks)
        return data_url('image/png', png(figure, dpi))


def _draw_scenario(axes: Axes, scenario: ScenarioMark) -> None:
    for path in scenario.paths:
        _draw_path(axes, path, len(scenario.paths))
    axes.set_title(as_written(f'{scenario.name}\n{scenario.points_text}'))
    axes.set(xlabel='x (m)', ylabel='y (m)')
    _fit(axes, scenario.paths)


def _draw_path(axes: Axes, path: RobotPath, nb_robots: int) -> None:
    wanted, own = _columns(path.wanted), _columns(path.own)
    axes.plot(*wanted, **_WANTED)
    look = line_look(path.robot, nb_robots)
    axes.plot(*own, **look)
    colour = look['color']
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
