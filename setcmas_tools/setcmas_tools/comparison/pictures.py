"""Pictures of runs over each other: their paths, and their distances over time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib import rcParams
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from setcmas_simu.errors import SetcmasError
from setcmas_tools.comparison.shift import Shifted
from setcmas_tools.plots.look import PlotLook
from setcmas_tools.plots.style import (
    finish,
    legend,
    line_look,
    plot_style,
    robot_handles,
    save_in,
    time_axis,
)
from setcmas_tools.plots.trajectories import (
    draw_world,
    finite_rows,
    fit_plane,
    shared_dashes,
    with_gaps,
)
from setcmas_tools.run.arena import arena_of, obstacles_of
from setcmas_tools.run.run import Run

_STYLES = ('solid', (0, (4, 2)), (0, (1, 1.5)), (0, (6, 2, 1, 2)))


def write_pictures(
    names: Sequence[str],
    runs: Sequence[Run],
    shifted: Sequence[Shifted],
    folder: Path,
    look: PlotLook,
) -> list[Path]:
    """Write the pictures of runs, of which the first is the reference.

    Args:
        names: What the runs are called.
        runs: The runs.
        shifted: All but the reference, beside it.
        folder: Where the files go.
        look: How they look.

    Returns:
        The files.

    Raises:
        SetcmasError: They cannot be written.
    """
    look.check()
    paths: list[Path] = []
    with plot_style(look.palette, look.paper):
        drawn = drawn_pictures(names, runs, shifted)
        try:
            folder.mkdir(parents=True, exist_ok=True)
            for name, figure in drawn.items():
                paths += save_in(look.formats, figure, folder / name)
        except OSError as error:
            raise SetcmasError(f"'{folder}' cannot be written: {error.strerror}") from error
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
        for robot in run.counted.robots:
            track = finite_rows(run.counted.of(robot), 'x', 'y')
            x, y = with_gaps(track, track.x, track.y)
            axes.plot(x, y, **line_look(robot, len(robots)) | _style(number))
    worlds = {(arena_of(run), obstacles_of(run)): run for run in runs}
    marks = {one.get_label(): one for run in worlds.values() for one in draw_world(axes, run)}
    for run in runs:
        fit_plane(axes, run.counted)
    legend(axes, [*robot_handles(robots), *marks.values(), *_run_handles(names)])
    return figure


def _distances(names: Sequence[str], shifted: Sequence[Shifted]) -> Figure:
    """Draw how far each robot is from itself in the reference, a panel for each other run."""
    figure = Figure(figsize=(9.0, 2.0 + 2.6 * len(shifted)))
    panels = list(figure.subplots(len(shifted), sharex=True, squeeze=False)[:, 0])
    for axes, name, beside in zip(panels, names[1:], shifted, strict=True):
        robots = list(beside.distances)
        dashes = shared_dashes([(beside.t, distance) for distance in beside.distances.values()])
        for (robot, distance), look in zip(beside.distances.items(), dashes, strict=True):
            axes.plot(beside.t, distance, **line_look(robot, len(robots)) | look)
        axes.set(ylabel=f'distance to {names[0]} (m)', ylim=(0.0, None))
        axes.set_title(f"'{name}', best shift in time")
        legend(axes, robot_handles(robots))
    time_axis(panels, min(one.t[0] for one in shifted), max(one.t[-1] for one in shifted))
    return figure


def _style(number: int) -> dict[str, Any]:
    return {'linestyle': _STYLES[number % len(_STYLES)]}


def _run_handles(names: Sequence[str]) -> list[Line2D]:
    look = {'color': '0.3', 'linewidth': rcParams['lines.linewidth']}
    return [
        Line2D([], [], label=name, **look, **_style(number)) for number, name in enumerate(names)
    ]
