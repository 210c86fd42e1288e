"""Plots of a run, and of compared runs: files, windows, and figures by name."""

from __future__ import annotations

import html as markup
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from matplotlib import rcParams
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from setcmas_simu.errors import SetcmasError
from setcmas_simu.plugins import PluginGroup, a_function
from setcmas_tools.measures.comparison import Shifted
from setcmas_tools.measures.metrics import failures, measure
from setcmas_tools.plots import trajectories
from setcmas_tools.plots.plot_options import PlotOptions
from setcmas_tools.plots.style import (
    as_written,
    data_url,
    drawn_robots,
    finish,
    legend,
    line_handles,
    line_look,
    plot_style,
    png,
    time_axis,
    write_figures,
)
from setcmas_tools.run.run import Run, arena_of, obstacles_of

Plot = Callable[['Figure', 'Run'], None]
"""Draws a run into an empty figure; the plot's name is the title of its first axes."""

Applies = Callable[['Run'], bool]


def applies_to(condition: Applies) -> Callable[[Plot], Plot]:
    """Return a decorator for plots that apply only to runs that fulfil a condition."""

    def decorate(plot: Plot) -> Plot:
        plot.applies = condition  # type: ignore[attr-defined]
        return plot

    return decorate


def suits(plot: Plot, run: Run) -> bool:
    """Return whether a plot applies to a run."""
    condition: Any = getattr(plot, 'applies', None)
    return condition is None or bool(condition(run))


PLOTS: PluginGroup[Plot] = PluginGroup('setcmas.plots', 'plot', a_function('draw(figure, run)'))
"""Installed plots."""


_FIRST = (
    'trajectories', 'positions', 'heading', 'velocities', 'distances', 'communication_instants',
    'communication_counts', 'inter_event_times', 'graph', 'disagreement', 'errors', 'filter',
)  # fmt: skip

_LOOK = PlotOptions()


def plots_of(run: Run, warn: Callable[[str], None] = print) -> dict[str, Plot]:
    """Return the plots that apply to a run by name, built-in plots first."""
    usable = PLOTS.usable(warn)
    names = [*(name for name in _FIRST if name in usable), *(usable.keys() - set(_FIRST))]
    return {name: usable[name] for name in names if suits(usable[name], run)}


def plot(
    run: Run, folder: Path, look: PlotOptions = _LOOK, warn: Callable[[str], None] = print
) -> list[Path]:
    """Write the plots that apply to a run; return the files.

    `warn` shows the error of a failing plot; the others continue.

    Raises:
        SetcmasError: An option is invalid, the plots cannot be written, or there is no screen to
            show them on.
    """
    from tqdm import tqdm  # a page draws plots without it

    drawn = drawn_plots(run, warn, window if look.show else Figure)
    progress = tqdm(drawn, 'plots', leave=False, disable=None, bar_format='{desc}: {n}')
    paths = write_figures(progress, folder, look)
    if look.show:
        with plot_style():
            show(folder)
    return paths


def drawn_plots(
    run: Run, warn: Callable[[str], None] = print, new: Callable[[], Figure] = Figure
) -> Iterator[tuple[str, Figure]]:
    """Draw and yield the plots that apply to a run by name; call within `plot_style`.

    `warn` shows the error of a failing plot; the others continue. `new` creates an empty figure.
    """
    for name, draw in plots_of(run, warn).items():
        with failures(f"plot '{name}'", warn):
            figure = new()
            draw(figure, run)
            finish(figure, run.title)
            yield name, figure


_SUMMARY_DPI = 55


def html(run: Run) -> str:
    """Return a run as HTML: its title, its trajectories, and the table of its metrics."""
    picture = data_url('image/png', png(figure(run, 'trajectories'), _SUMMARY_DPI))
    try:
        table = str(measure(run, lambda _: None))
    except SetcmasError as error:
        table = str(error)
    return (
        f'<div><b>{markup.escape(run.title)}</b> ({markup.escape(str(run.outcome))})<br>'
        f'<img src="{picture}" alt="trajectories">'
        f'<pre style="line-height:1.2">{markup.escape(table)}</pre></div>'
    )


class Picture(Figure):
    """A figure that a notebook shows."""

    def _repr_png_(self) -> bytes:
        with plot_style():
            return png(self, 100)


def figure(run: Run, name: str) -> Figure:
    """Return a plot of a run, or raise SetcmasError."""
    draw = PLOTS.get(name)
    if not suits(draw, run):
        known = ', '.join(plots_of(run))
        raise SetcmasError(f"plot '{name}' does not apply to this run; must be one of {known}")
    with plot_style():
        picture = Picture()
        draw(picture, run)
        finish(picture, run.title)
    return picture


def window() -> Any:
    """Return a figure for `show`."""
    from matplotlib import pyplot  # only needed for windows; it requires a screen

    return pyplot.figure()


def show(folder: Path) -> None:
    """Open the figures of `window` until the user closes them; SetcmasError without a screen."""
    from matplotlib import pyplot

    if pyplot.get_backend().lower() == 'agg':
        raise SetcmasError(f"no screen to show plots on; they are in '{folder}'")
    pyplot.show()


_STYLES = ('solid', (0, (4, 2)), (0, (1, 1.5)), (0, (6, 2, 1, 2)))


def drawn_pictures(
    names: Sequence[str], runs: Sequence[Run], shifted: Sequence[Shifted]
) -> Iterator[tuple[str, Figure]]:
    """Draw and yield the pictures of compared runs by name; call within `plot_style`.

    The first run is the reference; `shifted` has the others, compared with it.
    """
    drawn = {'paths': _paths(names, runs), 'distances': _distances(names, shifted)}
    for name, figure in drawn.items():
        finish(figure, f'{names[0]} and {", ".join(names[1:])}')
        yield name, figure


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
        curves = {robot: (other.t, other.distances[robot]) for robot in drawn_robots(robots)}
        trajectories.draw_curves(axes, curves, len(robots))
        axes.set(ylabel=as_written(f'distance to {names[0]} (m)'), ylim=(0.0, None))
        shift = f', shifted by {-other.shift:g} s' if other.shift else ''
        axes.set_title(as_written(f'{name}{shift}'))
        legend(axes, line_handles(robots))
    time_axis(panels, min(one.t[0] for one in shifted), max(one.t[-1] for one in shifted))
    return figure


def _style(number: int) -> dict[str, Any]:
    return {'linestyle': _STYLES[number % len(_STYLES)]}
