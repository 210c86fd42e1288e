"""What the robots were to reach, and where they might be, drawn into a plot of the plane."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from setcmas_expe.arena import Arena
from setcmas_tools.plots.lines import finite_rows
from setcmas_tools.records.fleet_table import FleetTable
from setcmas_tools.run.references import References

Floats = NDArray[np.float64]

_DOTTED: dict[str, Any] = {'color': '0.15', 'linestyle': (0, (1, 2)), 'zorder': 2.6}
_CORNERS = 181


def draw_references(axes: Axes, table: FleetTable, references: References) -> list[Line2D]:
    """Draw waypoints, a circular reference, and places in a formation at the end of the run.

    Args:
        axes: A plot of the plane in m.
        table: The fleet's motion.
        references: What is drawn of them; what is None is left out.

    Returns:
        What to put in the legend.
    """
    handles: list[Line2D] = []
    if references.waypoints is not None:
        handles += axes.plot(*references.waypoints.T, label='waypoints', **_mark('s', 1.1))
        axes.plot(*references.waypoints.T, linewidth=_width(), **_DOTTED)
    if references.radius is not None:
        angles = np.linspace(0.0, 2 * np.pi, _CORNERS)
        x, y = references.radius * np.cos(angles), references.radius * np.sin(angles)
        handles += axes.plot(x, y, label='reference', linewidth=1.5 * _width(), **_DOTTED)
    if references.places is not None:
        places = _places_at_end(table, references.places)
        if len(places):
            handles += axes.plot(*places.T, label='places at the end', **_mark('o', 2.8))
    return handles


def draw_arena(axes: Axes, arena: Arena) -> list[Line2D]:
    """Draw the border of an arena; returns what to put in the legend."""
    x = [arena.xmin, arena.xmax, arena.xmax, arena.xmin, arena.xmin]
    y = [arena.ymin, arena.ymin, arena.ymax, arena.ymax, arena.ymin]
    return axes.plot(x, y, label='arena', color='0.55', linewidth=_width(), zorder=1.5)


def _places_at_end(table: FleetTable, places: Floats) -> Floats:
    """Return the followers' places in m beside where the leader, robot 1, ends."""
    leader = finite_rows(table.of(1), 'x', 'y')
    if not len(leader.t):
        return np.empty((0, 2))
    return np.array([leader.x[-1], leader.y[-1]]) + places[: max(table.robots) - 1]


def _width() -> float:
    return 0.7 * float(rcParams['lines.linewidth'])


def _mark(marker: str, size: float) -> dict[str, Any]:
    return {
        'marker': marker,
        'markersize': size * rcParams['lines.markersize'],
        'markerfacecolor': 'none',
        'markeredgecolor': '0.15',
        'markeredgewidth': _width(),
        'linestyle': '',
        'zorder': 2.7,
    }
