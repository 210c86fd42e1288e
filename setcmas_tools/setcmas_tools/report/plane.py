"""The plane around the robots for the page: references, arena, obstacles, drawings, links."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from setcmas_simu.arrays import Floats
from setcmas_tools.plots.style import plot_style
from setcmas_tools.plots.trajectories import draw_references
from setcmas_tools.replay.history import RunHistory
from setcmas_tools.report.packing import changes, packed
from setcmas_tools.run.law_output import MARKER, Drawing, DrawnOverTime
from setcmas_tools.run.run import Run, arena_of, obstacles_of

_MOST_DRAWINGS = 8_000


def plane_entry(history: RunHistory) -> dict[str, Any]:
    """Return what there is in the plane besides robots."""
    run = history.run
    record = run.record
    obstacles = obstacles_of(run)
    return {
        'arena': arena_of(run),
        'discs': obstacles.discs,
        'polygons': [one.corners for one in obstacles.polygons],
        'references': _references(run),
        'drawings': _drawings(history),
        'links': None if record is None else np.round(record.changes, 4).tolist(),
        'sent': {
            robot: packed(t) for robot, t in (record.trigger_times if record else {}).items()
        },
    }


def _references(run: Run) -> list[dict[str, Any]]:
    """Return the lines that the run's task draws into a film."""
    axes: Axes = Figure().add_subplot()
    with plot_style():
        draw_references('film', axes, run)
    return [_line(one) for one in axes.lines]


def _line(line: Line2D) -> dict[str, Any]:
    points: Floats = np.round(np.asarray(line.get_xydata(), dtype=float), 4)
    return {
        'points': points[np.isfinite(points).all(axis=1)].tolist(),
        'colour': to_hex(line.get_color()),
        'marked': line.get_marker() not in ('', ' ', 'None', None),
        'joined': line.get_linestyle() not in ('', ' ', 'None'),
    }


def _drawings(history: RunHistory) -> list[dict[str, Any]]:
    """Return what scripts drew, a column for each marker and each trail."""
    columns: dict[tuple[int, str, str], list[Drawing]] = {}
    shown = DrawnOverTime(history.run.drawings).shown
    for one in shown:
        columns.setdefault((one.robot, one.name, one.kind), []).append(one)
    each = 1 + len(shown) // _MOST_DRAWINGS
    return [_column(drawn[::each], kind == MARKER) for (_, _, kind), drawn in columns.items()]


def _column(drawn: Sequence[Drawing], is_marker: bool) -> dict[str, Any]:
    spheres = [one.sphere for one in drawn]
    looks = [(round(s.diameter, 3), _hex(s.colour), round(s.alpha, 3)) for s in spheres]
    return {
        'marker': is_marker,
        't': packed([one.t for one in drawn]),
        'x': packed([s.x for s in spheres]),
        'y': packed([s.y for s in spheres]),
        'looks': changes(looks),
    }


def _hex(colour: Sequence[float]) -> str:
    red, green, blue = (min(max(part, 0.0), 1.0) for part in colour)
    return to_hex((red, green, blue))
