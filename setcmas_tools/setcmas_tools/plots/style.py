"""Style of all plots: colours and lines of robots, legends, titles, saving."""

from __future__ import annotations

import base64
import contextlib
import io
import math
import warnings
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from matplotlib import rcParams, style
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import AbstractPathEffect, withStroke

from setcmas_simu.errors import file_errors
from setcmas_simu.fleet import palettes
from setcmas_simu.fleet.palettes import Colour, is_bright, plot_colour
from setcmas_tools.plots.plot_options import PlotOptions

_DASHES: tuple[Any, ...] = ('solid', (0, (4, 1.6)))
_SAMPLES = 5
"""Number of legend entries for a fleet with a continuous colour scale."""


def robot_dashes(robot: int, nb_robots: int) -> Any:
    """Return the line style of a robot, which distinguishes robots of one colour."""
    if palettes.is_scale(nb_robots):
        return 'solid'
    return _DASHES[(robot - 1) // palettes.NB_COLOURS % len(_DASHES)]


def legend_robots(robots: list[int]) -> list[int]:
    """Return the robots with legend entries: all, or a few on a continuous scale."""
    if not palettes.is_scale(len(robots)):
        return robots
    last = len(robots) - 1
    return [robots[round(i * last / (_SAMPLES - 1))] for i in range(_SAMPLES)]


_MOST_DRAWN = 100


def drawn_robots(robots: list[int]) -> list[int]:
    """Return the robots that get a line: all, or every n-th of a large fleet, to save time."""
    return robots[:: 1 + len(robots) // (_MOST_DRAWN + 1)]


_AROUND_PANEL_IN = 0.35  # ticks and labels
_MANY_ROBOTS = 12
"""Fleets of at least this size get thinner lines."""


_STYLE = Path(__file__).parent / 'templates' / 'screen.mplstyle'


@contextlib.contextmanager
def plot_style() -> Iterator[None]:
    """Draw and save inside in the style of these plots, regardless of the user's settings."""
    with style.context(['default', _STYLE]):
        yield


def as_written(text: str) -> str:
    """Return a text of a user, such as a file name, in which $ begins no formula."""
    return text.replace('$', r'\$')


def finish(figure: Figure, run: str = '') -> None:
    """Add the run to a plot's title.

    Args:
        figure: A drawn plot, with its name as the title of its first axes.
        run: Description, such as 'consensus, 8 robots'.
    """
    figure.axes[0].set_title(
        as_written(run), loc='right', fontsize=rcParams['legend.fontsize'], color='0.4'
    )


def write_figures(
    drawn: Iterable[tuple[str, Figure]], folder: Path, look: PlotOptions
) -> list[Path]:
    """Write figures by name in the formats of a look, as they are drawn; return the files.

    Raises:
        SetcmasError: They cannot be written.
    """
    paths = []
    with plot_style(), file_errors(f"plots cannot be written to '{folder}'"):
        folder.mkdir(parents=True, exist_ok=True)
        for name, figure in drawn:
            for ending in look.format:
                paths.append(folder / f'{name}.{ending}')
                save(figure, paths[-1])
    return paths


def save(figure: Figure, path: Path) -> None:
    """Write a figure; equal figures give equal bytes.

    Args:
        figure: Made and saved within `plot_style`.
        path: The file; its suffix .png, .pdf or .svg is the format.
    """
    date = {'.pdf': 'CreationDate', '.svg': 'Date'}.get(path.suffix)
    with warnings.catch_warnings():
        warnings.filterwarnings('ignore', 'Glyph .* missing')  # a name in another alphabet
        figure.savefig(path, metadata={date: None} if date else {})


def png(figure: Figure, dpi: float) -> bytes:
    """Return a figure as the content of a PNG file."""
    content = io.BytesIO()
    figure.savefig(content, format='png', dpi=dpi)
    return content.getvalue()


def data_url(kind: str, content: bytes) -> str:
    """Return the content of a file as a URL for pages; `kind` is such as 'image/png'."""
    return f'data:{kind};base64,{base64.b64encode(content).decode("ascii")}'


def line_look(robot: int, nb_robots: int) -> dict[str, Any]:
    """Return keyword arguments for the line of a robot in a fleet of nb_robots."""
    width = rcParams['lines.linewidth'] * (1.0 if nb_robots < _MANY_ROBOTS else 0.7)
    look: dict[str, Any] = {
        'color': plot_colour(robot, nb_robots),
        'linewidth': width,
        'linestyle': robot_dashes(robot, nb_robots),
    }
    if effects := edge_effects(look['color'], width):
        look['path_effects'] = effects
    return look


def edge_effects(colour: Colour, width: float) -> list[AbstractPathEffect]:
    """Return a dark edge for a line of this width whose colour is too bright for white paper."""
    if not is_bright(colour):
        return []
    return [withStroke(linewidth=1.1 * width + 0.5, foreground='0.25')]


def robot_handles(robots: list[int]) -> list[Artist]:
    """Return legend entries for each robot, or for some robots of a large fleet."""
    return [
        Line2D([], [], label=f'robot {robot}', **line_look(robot, len(robots)))
        for robot in legend_robots(robots)
    ]


def line_handles(robots: list[int]) -> list[Artist]:
    """Return legend entries for plots of `drawn_robots`; they say how many these are."""
    drawn = drawn_robots(robots)
    if len(drawn) == len(robots):
        return robot_handles(robots)
    label = f'{len(drawn):,} of {len(robots):,} robots drawn'
    return [*robot_handles(robots), Line2D([], [], label=label, linestyle='')]


def legend(axes: Axes, handles: Iterable[Artist]) -> None:
    """Put a legend, if it has entries, outside the axes on the right."""
    entries = list(handles)
    if not entries:
        return
    lines = [line for entry in entries for line in str(entry.get_label()).splitlines()]
    axes.legend(
        handles=entries, loc='upper left', bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0,
        ncols=_columns(axes, len(lines)),
    )  # fmt: skip


def _columns(axes: Axes, nb_lines: int) -> int:
    """Return the number of columns that keeps a legend as low as its panel."""
    place = axes.get_subplotspec()
    rows = place.get_gridspec().nrows if place else 1
    panel = axes.figure.figure.get_figheight() / rows - _AROUND_PANEL_IN
    entry = float(rcParams['legend.fontsize'] * (1 + rcParams['legend.labelspacing'])) / 72
    return max(1, math.ceil(nb_lines * entry / panel))


def time_axis(panels: Sequence[Axes], first: float, last: float) -> list[Artist]:
    """Label the time axis (s) of panels, and mark the first command if data start well before it.

    Returns:
        Entries for the legend.
    """
    panels[-1].set_xlabel('time (s)')
    panels[-1].set_xlim(first, last if last > first else first + 1.0)
    if -first < 0.01 * (last - first):
        return []
    look: dict[str, Any] = {'color': '0.55', 'linewidth': 1.0, 'linestyle': (0, (4, 3))}
    for axes in panels:
        axes.axvline(0.0, zorder=1, **look)
    return [Line2D([], [], label='first command', **look)]
