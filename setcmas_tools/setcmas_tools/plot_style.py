"""The look of all plots: style, colours of robots, legends, and how figures are saved."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from matplotlib import style
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import AbstractPathEffect, withStroke

from setcmas_simu import fleet

_STYLE: dict[str, Any] = {
    'figure.constrained_layout.use': True,
    'figure.dpi': 100,
    'savefig.dpi': 150,
    'font.size': 11,
    'axes.titlesize': 13,
    'axes.grid': True,
    'axes.axisbelow': True,
    'axes.spines.top': False,
    'axes.spines.right': False,
    'grid.color': '0.9',
    'legend.fontsize': 10,
    'legend.frameon': False,
    'lines.linewidth': 1.6,
    'lines.solid_capstyle': 'round',
    'lines.solid_joinstyle': 'round',
    'pdf.fonttype': 42,
    'svg.fonttype': 'path',
    'svg.hashsalt': 'setcmas',
}
_BRIGHT = 0.6
"""Luminance from which a colour needs a dark edge on white paper."""
_MANY_ROBOTS = 12
"""Fleets from this size are drawn with thinner lines."""


@contextlib.contextmanager
def plot_style() -> Iterator[None]:
    """Draw and save in the style of these plots, whatever the user's own settings are."""
    with style.context(['default', _STYLE]):
        yield


def save(figure: Figure, path: Path) -> None:
    """Write a figure; the same figure gives the same bytes.

    Args:
        figure: Made and saved within `plot_style`.
        path: Its suffix, .png, .pdf or .svg, is the format.
    """
    date = {'.pdf': 'CreationDate', '.svg': 'Date'}.get(path.suffix)
    figure.savefig(path, metadata={date: None} if date else {})


def line_look(robot: int, nb_robots: int) -> dict[str, Any]:
    """Return the keywords of the line of a robot in a fleet of nb_robots."""
    width = 1.6 if nb_robots < _MANY_ROBOTS else 1.1
    look: dict[str, Any] = {'color': fleet.plot_colour(robot), 'linewidth': width}
    if effects := edge_effects(robot, width):
        look['path_effects'] = effects
    if _is_grey(robot):
        look |= {'alpha': 0.7, 'zorder': 1.9}  # behind the robots with a colour of their own
    return look


def edge_effects(robot: int, width: float) -> list[AbstractPathEffect]:
    """Return a dark edge for the line of a robot whose colour is too bright for white paper."""
    red, green, blue = fleet.plot_colour(robot)
    if 0.2126 * red + 0.7152 * green + 0.0722 * blue < _BRIGHT:
        return []
    return [withStroke(linewidth=width + 0.9, foreground='0.25')]


def robot_handles(robots: list[int]) -> list[Artist]:
    """Return a legend entry for each robot, and one for all those in grey."""
    coloured = [robot for robot in robots if not _is_grey(robot)]
    greys = [robot for robot in robots if _is_grey(robot)]
    handles: list[Artist] = [
        Line2D([], [], label=f'robot {robot}', **line_look(robot, 1)) for robot in coloured
    ]
    if greys:
        name = 'robot' if len(greys) == 1 else 'robots'
        label = f'{name} {fleet.format_robots(greys).replace("-", "–")}'
        handles.append(Line2D([], [], label=label, **line_look(greys[0], 1)))
    return handles


def legend(axes: Axes, handles: Iterable[Artist]) -> None:
    """Put a legend to the right of the axes, where it cannot cover anything."""
    axes.legend(
        handles=list(handles), loc='upper left', bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0
    )


def time_axis(panels: Sequence[Axes], first: float, last: float) -> list[Artist]:
    """Label the time axis (s) of panels, and mark the first command if data begin well before it.

    Returns:
        What to put in the legend.
    """
    panels[-1].set_xlabel('time (s)')
    panels[-1].set_xlim(first, last if last > first else first + 1.0)
    if -first < 0.01 * (last - first):
        return []
    look: dict[str, Any] = {'color': '0.55', 'linewidth': 1.0, 'linestyle': (0, (4, 3))}
    for axes in panels:
        axes.axvline(0.0, zorder=1, **look)
    return [Line2D([], [], label='first command', **look)]


def _is_grey(robot: int) -> bool:
    return fleet.plot_colour(robot) == fleet.plot_colour(10_000)
