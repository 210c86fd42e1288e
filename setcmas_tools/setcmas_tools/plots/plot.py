"""Plots of a run: files, windows, and figures by name."""

from __future__ import annotations

import base64
import html as markup
import io
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from setcmas_simu.errors import SetcmasError, file_errors
from setcmas_simu.fleet.palettes import PALETTES
from setcmas_simu.plugins import InvalidPluginError, PluginGroup
from setcmas_tools.measures.metrics import measure
from setcmas_tools.measures.task import ignore
from setcmas_tools.plots.plot_options import PlotOptions
from setcmas_tools.plots.style import finish, plot_style, save_in
from setcmas_tools.run.run import Run

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


def _plot(thing: object) -> Plot:
    if not callable(thing):
        raise InvalidPluginError(f'it is a {type(thing).__name__}; it must be draw(figure, run)')
    return thing


PLOTS = PluginGroup('setcmas.plots', 'plot', _plot)
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

    with plot_style(look.palette, look.paper):
        paths = []
        with file_errors(f"plots cannot be written to '{folder}'"):
            folder.mkdir(parents=True, exist_ok=True)
            drawn = drawn_plots(run, warn, window if look.show else Figure)
            for name, figure in tqdm(
                drawn, 'plots', leave=False, disable=None, bar_format='{desc}: {n}'
            ):
                paths += save_in(look.formats, figure, folder / name)
        if look.show:
            show(folder)
    return paths


def drawn_plots(
    run: Run, warn: Callable[[str], None] = print, new: Callable[[], Figure] = Figure
) -> Iterator[tuple[str, Figure]]:
    """Draw and yield the plots that apply to a run by name; call within `plot_style`.

    `warn` shows the error of a failing plot; the others continue. `new` creates an empty figure.
    """
    for name, draw in plots_of(run, warn).items():
        figure = new()
        try:
            draw(figure, run)
            finish(figure, run.title)
        except (SetcmasError, OSError):
            raise
        except Exception as error:  # a plugin may raise anything
            reason = ' '.join(f'{type(error).__name__}: {error}'.split())
            warn(f"plot '{name}' failed: {reason}")
            continue
        yield name, figure


_SUMMARY_DPI = 55


def html(run: Run) -> str:
    """Return a run as HTML: its title, its trajectories, and the table of its metrics."""
    content = io.BytesIO()
    figure(run, 'trajectories').savefig(content, format='png', dpi=_SUMMARY_DPI)
    picture = base64.b64encode(content.getvalue()).decode('ascii')
    try:
        table = str(measure(run, ignore))
    except SetcmasError as error:
        table = str(error)
    return (
        f'<div><b>{markup.escape(run.title)}</b> ({markup.escape(str(run.outcome))})<br>'
        f'<img src="data:image/png;base64,{picture}" alt="trajectories">'
        f'<pre style="line-height:1.2">{markup.escape(table)}</pre></div>'
    )


class Picture(Figure):
    """A figure that a notebook shows."""

    def _repr_png_(self) -> bytes:
        content = io.BytesIO()
        with plot_style():
            self.savefig(content, format='png', dpi=100)
        return content.getvalue()


def figure(run: Run, name: str, palette: str = PALETTES[0], paper: str | None = None) -> Figure:
    """Return a plot of a run, or raise SetcmasError."""
    look = PlotOptions(palette=palette, paper=paper)
    draw = PLOTS.get(name)
    if not suits(draw, run):
        known = ', '.join(plots_of(run))
        raise SetcmasError(f"plot '{name}' does not apply to this run; must be one of {known}")
    with plot_style(look.palette, look.paper):
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
