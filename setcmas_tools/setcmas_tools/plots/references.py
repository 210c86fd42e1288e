"""References of a task, drawn into a plot of the plane."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from setcmas_expe.arena import Arena
from setcmas_tools.kinds.task import task_of
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


def draw_arena(axes: Axes, run: Run) -> list[Line2D]:
    """Draw the border of the arena of an experiment; returns what to put in the legend."""
    arena = _arena(run.parameters.get('arena'))
    if arena is None:
        return []
    x = [arena.xmin, arena.xmax, arena.xmax, arena.xmin, arena.xmin]
    y = [arena.ymin, arena.ymin, arena.ymax, arena.ymax, arena.ymin]
    return axes.plot(x, y, label='arena', color='0.55', linewidth=line_width(), zorder=1.5)


def _arena(sides: Any) -> Arena | None:
    """Return the arena of four recorded sides in m; None if they are not that."""
    with suppress(TypeError, ValueError):
        return Arena(*map(float, sides))
    return None


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
