"""References of tasks, drawn into plots and films: waypoints, places, reference paths, boxes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.palettes import plot_colour
from setcmas_tools.measures.task_errors import LEADER, placed, wanted_distances
from setcmas_tools.measures.task_metrics import known_places, squared_distances
from setcmas_tools.run.run import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

_DOTTED: dict[str, Any] = {'color': '0.15', 'linestyle': (0, (1, 2)), 'zorder': 2.6}
_CORNERS = 181  # of a circle
_PIXELS = 400  # along each side of a box
_MOST_REFERENCES = 4  # of several distances in a plot

Draw = Callable[['Axes', 'Run', Mapping[str, Any], bool], 'list[Line2D]']
"""Draws the references of a run in the plane (m); the flag says whether for a film."""


def draw_references(axes: Axes, run: Run, is_film: bool = False) -> list[Line2D]:
    """Draw the references of a run's task in the plane; return entries for the legend."""
    if not draws_references(run):
        return []
    assert run.references
    return _DRAWN[run.references.task](axes, run, run.references.values, is_film)


def draws_references(run: Run) -> bool:
    """Return whether the task of a run has references in the plane; matplotlib may be missing."""
    return run.references is not None and run.references.task in _DRAWN


def draw_wanted_distances(axes: Axes, run: Run) -> list[Line2D]:
    """Draw the wanted distances of a run's pairs (m), if they are few; return legend entries."""
    if run.references is None or run.references.task != 'distances':
        return []
    shape = run.references.values['D']
    wanted = wanted_distances(placed(run.counted_grid, shape).robots, shape)
    values = np.unique(wanted[np.triu_indices(len(wanted), 1)].round(3)).tolist()
    if not 0 < len(values) <= _MOST_REFERENCES:
        return []
    label = f'reference, {", ".join(format(value, "g") for value in values)} m'
    look: dict[str, Any] = {'color': '0.15', 'linestyle': ':', 'zorder': 2.6}
    return [axes.axhline(value, label=label, **look) for value in values][:1]


def line_width() -> float:
    """Return the line width of a reference in points."""
    from matplotlib import rcParams  # here: a page in a browser may do without matplotlib

    return 0.7 * float(rcParams['lines.linewidth'])


def _hollow_marker(marker: str, size: float) -> dict[str, Any]:
    """Return the style of a hollow marker, its size relative to normal markers."""
    from matplotlib import rcParams

    return {
        'marker': marker,
        'markersize': size * rcParams['lines.markersize'],
        'markerfacecolor': 'none',
        'markeredgecolor': '0.15',
        'markeredgewidth': line_width(),
        'linestyle': '',
        'zorder': 2.7,
    }


def _tracking(axes: Axes, _run: Run, wanted: Mapping[str, Any], _is_film: bool) -> list[Line2D]:
    angles = np.linspace(0.0, 2 * np.pi, _CORNERS)
    x, y = wanted['R'] * np.cos(angles), wanted['R'] * np.sin(angles)
    return axes.plot(x, y, label='reference', linewidth=1.5 * line_width(), **_DOTTED)


def _waypoints(axes: Axes, _run: Run, wanted: Mapping[str, Any], _is_film: bool) -> list[Line2D]:
    """Draw waypoints in the order of the list."""
    if 'WPL' not in wanted:
        return []
    points = np.array(wanted['WPL']).T
    handles = axes.plot(*points, label='waypoints', **_hollow_marker('s', 1.1))
    axes.plot(*points, linewidth=line_width(), **_DOTTED)
    return handles


def _formation(axes: Axes, run: Run, wanted: Mapping[str, Any], is_film: bool) -> list[Line2D]:
    """Draw waypoints, and the followers' places relative to the leader's end position."""
    handles = _waypoints(axes, run, wanted, is_film)
    leader = run.table.of(LEADER)
    leader = leader.rows(np.isfinite(leader.x + leader.y))
    # In a film they would have to move along with the leader.
    if is_film or not len(leader.t) or max(run.robots) == LEADER:
        return handles
    places = np.array(wanted['PLACES'])[: max(run.robots) - 1]
    at_end = np.array([leader.x[-1], leader.y[-1]]) + places
    return handles + axes.plot(*at_end.T, label='places at the end', **_hollow_marker('o', 2.8))


def _coverage(axes: Axes, run: Run, wanted: Mapping[str, Any], is_film: bool) -> list[Line2D]:
    """Draw the box, and in a plot colour each of its points like the robot nearest to it."""
    (left, bottom), (right, top) = wanted['BOX']
    places, robots = known_places(run.counted_grid), run.counted_grid.robots
    if not is_film and len(places):
        corners: Floats = np.array(wanted['BOX'])
        nearest = squared_distances(corners, places[-1], _PIXELS).argmin(axis=0)
        colours = np.array([plot_colour(robot, len(robots)) for robot in robots])
        extent = (left, right, bottom, top)
        axes.imshow(colours[nearest], extent=extent, origin='lower', alpha=0.2, zorder=0.5)
    x, y = [left, right, right, left, left], [bottom, bottom, top, top, bottom]
    return axes.plot(x, y, label='box', color='0.15', linestyle=':', zorder=1.5)


_DRAWN: dict[str, Draw] = {
    'coverage': _coverage,
    'distances': _waypoints,
    'formation': _formation,
    'tracking': _tracking,
    'waypoints': _waypoints,
}
"""How the references of each task are drawn."""
