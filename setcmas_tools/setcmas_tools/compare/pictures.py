"""Pictures of compared runs, and of an identification."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import robot_name
from setcmas_tools.compare.identification import FORWARD, TURN, Channel, Identified
from setcmas_tools.compare.run_distance import Shifted
from setcmas_tools.plots import trajectories
from setcmas_tools.plots.plot_settings import PlotSettings
from setcmas_tools.plots.style import (
    finish,
    legend,
    line_look,
    plot_style,
    robot_handles,
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
    look: PlotSettings,
) -> list[Path]:
    """Write the pictures of runs, of which the first is the reference.

    Args:
        names: Names of the runs.
        runs: The runs.
        shifted: All but the reference, compared with it.
        folder: Folder of the files.
        look: Style of the plots.

    Returns:
        The files.

    Raises:
        SetcmasError: They cannot be written.
    """
    look.check()
    with plot_style(look.palette, look.paper):
        drawn = drawn_pictures(names, runs, shifted)
        return _saved({folder / name: figure for name, figure in drawn.items()}, look)


def _saved(figures: Mapping[Path, Figure], look: PlotSettings) -> list[Path]:
    """Save figures under paths without an ending; return the files."""
    paths: list[Path] = []
    for path, figure in figures.items():
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            paths += save_in(look.formats, figure, path)
        except OSError as error:
            raise SetcmasError(f"'{path}' cannot be written: {error.strerror}") from error
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
    legend(axes, [*robot_handles(robots), *marks.values(), *_run_handles(names)])
    return figure


def _distances(names: Sequence[str], shifted: Sequence[Shifted]) -> Figure:
    """Draw how far each robot is from itself in the reference, a panel for each other run."""
    figure = Figure(figsize=(9.0, 2.0 + 2.6 * len(shifted)))
    panels = list(figure.subplots(len(shifted), sharex=True, squeeze=False)[:, 0])
    for axes, name, other in zip(panels, names[1:], shifted, strict=True):
        robots = list(other.distances)
        dashes = trajectories.shared_dashes(
            [(other.t, distance) for distance in other.distances.values()]
        )
        for (robot, distance), look in zip(other.distances.items(), dashes, strict=True):
            axes.plot(other.t, distance, **line_look(robot, len(robots)) | look)
        axes.set(ylabel=f'distance to {names[0]} (m)', ylim=(0.0, None))
        axes.set_title(f"'{name}', shifted by {-other.shift:g} s" if other.shift else f"'{name}'")
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


_SHOWN_S = 15.0
_UNITS = {FORWARD: 'm/s', TURN: 'rad/s'}
_COMMANDED: dict[str, Any] = {'color': '0.6', 'linewidth': 1.0, 'drawstyle': 'steps-post'}
_FITTED: dict[str, Any] = {'color': 'black', 'linewidth': 1.0, 'linestyle': (0, (4, 2))}


def write_picture(
    found: Mapping[int, Identified], title: str, path: Path, look: PlotSettings
) -> list[Path]:
    """Write the speeds of robots in the seconds in which their commands change most.

    Args:
        found: The robots.
        title: Title of the run.
        path: The file, whose ending is that of a format.
        look: Style of the plot.

    Returns:
        The files, one for each format.

    Raises:
        SetcmasError: A file cannot be written.
    """
    look.check()
    shown = {robot: one.channels for robot, one in found.items() if one.channels}
    if not shown:
        return []
    with plot_style(look.palette, look.paper):
        figure = _figure(shown)
        finish(figure, title)
        return _saved({path.with_suffix(''): figure}, look)


def _figure(shown: Mapping[int, Mapping[str, Channel]]) -> Figure:
    rows = [(robot, name) for robot in shown for name in shown[robot]]
    figure = Figure(figsize=(9.0, 1.0 + 1.7 * len(rows)))
    panels = list(figure.subplots(len(rows), sharex=True, squeeze=False)[:, 0])
    begin = _liveliest([one for channels in shown.values() for one in channels.values()])
    for axes, (robot, name) in zip(panels, rows, strict=True):
        colour = line_look(robot, len(shown))['color']
        _draw(axes, shown[robot][name], begin, colour)
        axes.set_ylabel(f'{robot_name(robot)}\n{_UNITS[name]}')
        axes.set_title(name)
    width = rcParams['lines.linewidth']
    legend(
        panels[0],
        [
            Line2D([], [], label='commanded', **_COMMANDED),
            Line2D([], [], label='measured', color='0.3', linewidth=width),
            Line2D([], [], label='fitted', **_FITTED),
        ],
    )
    time_axis(panels, begin, begin + _SHOWN_S)
    figure.align_ylabels(panels)
    return figure


def _draw(axes: Axes, channel: Channel, begin: float, colour: object) -> None:
    measured = channel.measured
    middle = 0.5 * (measured.begin + measured.end)
    near = (middle > begin) & (middle < begin + _SHOWN_S)
    t, u = measured.command.changes
    first, last = np.searchsorted(t, (begin, begin + _SHOWN_S))
    held = slice(max(0, first - 1), last)
    axes.plot([*t[held], begin + _SHOWN_S], [*u[held], u[held][-1]], **_COMMANDED)
    axes.plot(middle[near], measured.y[near], color=colour)
    if channel.fit.gain_known:
        axes.plot(middle[near], measured.predicted(channel.fit.response)[near], **_FITTED)


def _liveliest(channels: Sequence[Channel]) -> float:
    """Return the start of the seconds in which commands change most."""
    first = min(float(one.measured.begin[0]) for one in channels)
    last = max(float(one.measured.end[-1]) for one in channels)
    begins = np.arange(first, max(first, last - _SHOWN_S) + 1.0)
    change = np.zeros(len(begins))
    for one in channels:
        t, u = one.measured.command.changes
        grown = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(u)))]) / max(1e-9, np.ptp(u))
        ends = [np.searchsorted(t, begins + shift) for shift in (0.0, _SHOWN_S)]
        change += grown[np.minimum(ends[1], len(t) - 1)] - grown[np.minimum(ends[0], len(t) - 1)]
    return float(begins[np.argmax(change)])
