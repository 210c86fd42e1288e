"""Pictures of compared runs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib import rcParams
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from setcmas_simu.errors import file_errors
from setcmas_tools.measures.comparison import Shifted
from setcmas_tools.plots import trajectories
from setcmas_tools.plots.plot_options import PlotOptions
from setcmas_tools.plots.style import (
    as_written,
    drawn_robots,
    finish,
    legend,
    line_handles,
    line_look,
    plot_style,
    save_in,
    time_axis,
)
from setcmas_tools.run.run import Run, arena_of, obstacles_of

_STYLES = ('solid', (0, (4, 2)), (0, (1, 1.5)), (0, (6, 2, 1, 2)))


def write_pictures(
    names: Sequence[str],
    runs: Sequence[Run],
    shifted: Sequence[Shifted],
    folder: Path,
    look: PlotOptions,
) -> list[Path]:
    """Write the pictures of runs, or raise SetcmasError; return the files.

    The first run is the reference; `shifted` has the others, compared with it.
    """
    paths: list[Path] = []
    with file_errors(f"'{folder}' cannot be written"):
        folder.mkdir(parents=True, exist_ok=True)
        with plot_style(look.palette, look.paper):
            for name, figure in drawn_pictures(names, runs, shifted).items():
                paths += save_in(look.formats, figure, folder / name)
    return paths


def drawn_pictures(
    names: Sequence[str], runs: Sequence[Run], shifted: Sequence[Shifted]
) -> dict[str, Figure]:
    """Return the pictures by name, drawn; called and used within `plot_style`."""
    drawn = {'paths': _paths(names, runs), 'distances': _distances(names, shifted)}
    for figure in drawn.values():
        finish(figure, f'{names[0]} and {", ".join(names[1:])}')
    return drawn


def _paths(names: Sequence[str], runs: Sequence[Run]) -> Figure:
    """Draw the robots in their colours, each run in a line style of its own."""
    figure = Figure(figsize=(8.0, 6.4))
    axes = figure.add_subplot(title='Paths')
    robots = sorted({robot for run in runs for robot in run.counted.robots})
    for number, run in enumerate(runs):
        for robot in set(drawn_robots(robots)) & set(run.counted.robots):
            track = trajectories.finite_rows(run.counted.of(robot), 'x', 'y')
            x, y = trajectories.with_gaps(track, track.x, track.y)
            axes.plot(x, y, **line_look(robot, len(robots)) | _style(number))
    worlds = {(arena_of(run), obstacles_of(run)): run for run in runs}
    marks = {
        one.get_label(): one
        for run in worlds.values()
        for one in trajectories.draw_world(axes, run)
    }
    for run in runs:
        trajectories.fit_plane(axes, run.counted)
    look = {'color': '0.3', 'linewidth': rcParams['lines.linewidth']}
    handles = [
        Line2D([], [], label=as_written(name), **look, **_style(number))
        for number, name in enumerate(names)
    ]
    legend(axes, [*line_handles(robots), *marks.values(), *handles])
    return figure


def _distances(names: Sequence[str], shifted: Sequence[Shifted]) -> Figure:
    """Draw how far each robot is from itself in the reference, a panel for each other run."""
    figure = Figure(figsize=(9.0, 2.0 + 2.6 * len(shifted)))
    panels = list(figure.subplots(len(shifted), sharex=True, squeeze=False)[:, 0])
    for axes, name, other in zip(panels, names[1:], shifted, strict=True):
        robots = list(other.distances)
        drawn = {robot: other.distances[robot] for robot in drawn_robots(robots)}
        dashes = trajectories.shared_dashes([(other.t, distance) for distance in drawn.values()])
        for (robot, distance), look in zip(drawn.items(), dashes, strict=True):
            axes.plot(other.t, distance, **line_look(robot, len(robots)) | look)
        axes.set(ylabel=as_written(f'distance to {names[0]} (m)'), ylim=(0.0, None))
        shift = f', shifted by {-other.shift:g} s' if other.shift else ''
        axes.set_title(as_written(f'{name}{shift}'))
        legend(axes, line_handles(robots))
    time_axis(panels, min(one.t[0] for one in shifted), max(one.t[-1] for one in shifted))
    return figure


def _style(number: int) -> dict[str, Any]:
    return {'linestyle': _STYLES[number % len(_STYLES)]}
