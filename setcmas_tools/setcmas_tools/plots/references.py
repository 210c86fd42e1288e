"""References of a task, drawn into a plot of the plane."""

from __future__ import annotations

from typing import Any

from matplotlib import rcParams
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch, Polygon

from setcmas_tools.kinds.task import task_of
from setcmas_tools.run.arena import arena_of, obstacles_of
from setcmas_tools.run.run import Run

DOTTED: dict[str, Any] = {'color': '0.15', 'linestyle': (0, (1, 2)), 'zorder': 2.6}
"""The look of a reference's line."""


def draw_references(plot: str, axes: Axes, run: Run) -> list[Line2D]:
    """Draw what the robots of a run were to reach, as their task draws it.

    Args:
        plot: What is drawn, as for `Task.draw`.
        axes: Where it is drawn.
        run: The run.

    Returns:
        What to put in the legend.
    """
    if not (known := task_of(run, ignore)):
        return []
    task, references = known
    return task.draw(plot, axes, run, references)


def ignore(_: str) -> None:
    """Take a message that is told elsewhere."""


def draw_world(axes: Axes, run: Run) -> list[Artist]:
    """Draw the arena's border and the obstacles of a run; returns what to put in the legend."""
    return [*_draw_arena(axes, run), *_draw_obstacles(axes, run)]


def _draw_obstacles(axes: Axes, run: Run) -> list[Artist]:
    obstacles = obstacles_of(run)
    shapes: list[Patch] = [Circle((x, y), radius) for x, y, radius in obstacles.discs]
    shapes += [Polygon(one.corners) for one in obstacles.polygons]
    for shape in shapes:
        shape.set(facecolor='0.8', edgecolor='0.55', linewidth=line_width(), zorder=1.4)
        axes.add_patch(shape)
    return [Patch(label='obstacle', facecolor='0.8', edgecolor='0.55')] if shapes else []


def _draw_arena(axes: Axes, run: Run) -> list[Line2D]:
    arena = arena_of(run)
    if arena is None:
        return []
    x = [arena.xmin, arena.xmax, arena.xmax, arena.xmin, arena.xmin]
    y = [arena.ymin, arena.ymin, arena.ymax, arena.ymax, arena.ymin]
    return axes.plot(x, y, label='arena', color='0.55', linewidth=line_width(), zorder=1.5)


def line_width() -> float:
    """Return the width of a reference's line in points."""
    return 0.7 * float(rcParams['lines.linewidth'])


def mark(marker: str, size: float) -> dict[str, Any]:
    """Return the look of a hollow mark, its size in those of usual marks."""
    return {
        'marker': marker,
        'markersize': size * rcParams['lines.markersize'],
        'markerfacecolor': 'none',
        'markeredgecolor': '0.15',
        'markeredgewidth': line_width(),
        'linestyle': '',
        'zorder': 2.7,
    }
