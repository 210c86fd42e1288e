"""Style of all plots: colours and lines of robots, legends, titles, saving."""

from __future__ import annotations

import contextlib
import math
import warnings
from collections.abc import Iterable, Iterator, Sequence
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib import colormaps, rcParams, style
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import AbstractPathEffect, withStroke

from setcmas_simu.fleet import fleet
from setcmas_simu.fleet.fleet import Colour, is_bright
from setcmas_tools.plots.look import PALETTES, PAPER, PAPERS, SCREEN

# M. Okabe and K. Ito, Color Universal Design, 2008; the most distinct on white paper first.
_OKABE_ITO: tuple[Colour, ...] = tuple(
    to_rgb(colour)
    for colour in (
        '#0072B2',  # blue
        '#D55E00',  # vermillion
        '#009E73',  # bluish green
        '#CC79A7',  # reddish purple
        '#E69F00',  # orange
        '#56B4E9',  # sky blue
        '#000000',  # black
        '#F0E442',  # yellow
    )
)
_DASHES: tuple[Any, ...] = ('solid', (0, (4, 1.6)))
_MOST_COLOURS = len(_OKABE_ITO) * len(_DASHES)
# J. R. Nuñez, C. R. Anderton, R. S. Renslow, PLOS ONE 13(7), 2018: the same for all readers.
_SCALE, _BRIGHTEST = colormaps['cividis'], 0.77
_SAMPLES = 5
"""Number of legend entries for a fleet with a continuous colour scale."""


def is_scale(palette: str, nb_robots: int) -> bool:
    """Return whether colours follow a continuous scale: too many robots for distinct ones."""
    return palette != 'robots' and nb_robots > _MOST_COLOURS


def palette_colour(palette: str, robot: int, nb_robots: int) -> Colour:
    """Return the colour of a robot in a fleet of nb_robots on white paper."""
    if palette == 'robots':
        return fleet.plot_colour(robot)
    if is_scale(palette, nb_robots):
        place = (robot - 1) % nb_robots / (nb_robots - 1)
        return to_rgb(_SCALE(_BRIGHTEST * place))
    return _OKABE_ITO[(robot - 1) % len(_OKABE_ITO)]


def robot_dashes(palette: str, robot: int, nb_robots: int) -> Any:
    """Return the line style of a robot, which distinguishes robots of one colour."""
    if palette == 'robots' or is_scale(palette, nb_robots):
        return 'solid'
    return _DASHES[(robot - 1) // len(_OKABE_ITO) % len(_DASHES)]


def is_shared(palette: str, robot: int) -> bool:
    """Return whether a robot has the common colour of robots beyond the palette."""
    return palette == 'robots' and fleet.plot_colour(robot) == fleet.plot_colour(10_000)


def legend_robots(palette: str, robots: list[int]) -> list[int]:
    """Return the robots with legend entries: all, or a few on a continuous scale."""
    distinct = [robot for robot in robots if not is_shared(palette, robot)]
    if not is_scale(palette, len(robots)):
        return distinct
    last = len(robots) - 1
    return [robots[round(i * last / (_SAMPLES - 1))] for i in range(_SAMPLES)]


_AROUND_PANEL_IN = 0.35  # ticks and labels
_MANY_ROBOTS = 12
"""Fleets of at least this size get thinner lines."""


@dataclass(frozen=True)
class _Choice:
    palette: str = PALETTES[0]
    paper: str | None = None


_SCREEN_CHOICE = _Choice()
_choice: ContextVar[_Choice] = ContextVar('_choice', default=_SCREEN_CHOICE)


@contextlib.contextmanager
def plot_style(palette: str = PALETTES[0], paper: str | None = None) -> Iterator[None]:
    """Draw and save inside in the style of these plots, regardless of the user's settings.

    Args:
        palette: One of `plot_formats.PALETTES`.
        paper: One of `plot_formats.PAPERS` for fonts and sizes of a printed paper; None for
            screens and slides.
    """
    token = _choice.set(_Choice(palette, paper))
    try:
        with style.context(['default', SCREEN | (PAPER if paper else {})]):
            yield
    finally:
        _choice.reset(token)


def finish(figure: Figure, run: str = '') -> None:
    """Add the run to a plot's title; on paper, which has captions, only fit it to its width.

    Args:
        figure: A drawn plot, with its name as the title of its first axes.
        run: Description, such as 'consensus, 8 robots'.
    """
    paper = _choice.get().paper
    if paper is None:
        title = run.replace('$', r'\$')  # in a file name, it does not begin a formula
        figure.axes[0].set_title(title, loc='right', fontsize=rcParams['font.size'], color='0.4')
        return
    for axes in figure.axes:
        axes.set_title('')
    has_legend = any(axes.get_legend() for axes in figure.axes)
    room = 0.5 if paper == 'column' and has_legend else 0.0  # inches for the legend above
    figure.set_size_inches(final_width(figure.get_figwidth()), _final_height(figure) + room)


def final_width(width: float) -> float:
    """Return the final width in inches of a figure that has this width on screens."""
    paper = _choice.get().paper
    return PAPERS[paper] if paper else width


def _final_height(figure: Figure) -> float:
    width, height = figure.get_size_inches()
    flat = 0.75 if _choice.get().paper == 'page' else 1.0  # wide figures are flatter
    return float(flat * height / width * final_width(width))


def save_in(formats: Sequence[str], figure: Figure, stem: Path) -> list[Path]:
    """Write a figure in several formats, as `save` does; return the files."""
    paths = [stem.with_name(f'{stem.name}.{ending}') for ending in formats]
    for path in paths:
        save(figure, path)
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


def robot_colour(robot: int, nb_robots: int) -> Colour:
    """Return the colour of a robot in a fleet of nb_robots, in the palette of this style."""
    return palette_colour(_choice.get().palette, robot, nb_robots)


def line_look(robot: int, nb_robots: int) -> dict[str, Any]:
    """Return keyword arguments for the line of a robot in a fleet of nb_robots."""
    palette = _choice.get().palette
    width = rcParams['lines.linewidth'] * (1.0 if nb_robots < _MANY_ROBOTS else 0.7)
    look: dict[str, Any] = {
        'color': robot_colour(robot, nb_robots),
        'linewidth': width,
        'linestyle': robot_dashes(palette, robot, nb_robots),
    }
    if effects := edge_effects(look['color'], width):
        look['path_effects'] = effects
    if is_shared(palette, robot):
        look |= {'alpha': 0.7, 'zorder': 1.9}  # behind robots with their own colour
    return look


def edge_effects(colour: Colour, width: float) -> list[AbstractPathEffect]:
    """Return a dark edge for a line of this width whose colour is too bright for white paper."""
    if not is_bright(colour):
        return []
    return [withStroke(linewidth=1.1 * width + 0.5, foreground='0.25')]


def robot_handles(robots: list[int]) -> list[Artist]:
    """Return legend entries for each robot, or for some robots of a large fleet."""
    palette = _choice.get().palette
    handles: list[Artist] = [
        Line2D([], [], label=f'robot {robot}', **line_look(robot, len(robots)))
        for robot in legend_robots(palette, robots)
    ]
    if greys := [robot for robot in robots if is_shared(palette, robot)]:
        name = 'robot' if len(greys) == 1 else 'robots'
        label = f'{name} {fleet.format_robots(greys).replace("-", "–")}'
        handles.append(Line2D([], [], label=label, **line_look(greys[0], len(robots))))
    return handles


def legend(axes: Axes, handles: Iterable[Artist]) -> None:
    """Put the legend outside the axes: to the right, or above in a paper's column."""
    entries = list(handles)
    lines = [line for entry in entries for line in str(entry.get_label()).splitlines()]
    if _choice.get().paper == 'column':
        longest = max(map(len, lines))
        columns = int(3.3 / (0.3 + 0.043 * longest))  # in inches
        axes.legend(
            handles=entries, loc='lower left', bbox_to_anchor=(0.0, 1.01), borderaxespad=0.0,
            ncols=max(1, columns),
        )  # fmt: skip
    else:
        axes.legend(
            handles=entries, loc='upper left', bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0,
            ncols=_columns(axes, len(lines)),
        )  # fmt: skip


def _columns(axes: Axes, nb_lines: int) -> int:
    """Return the number of columns that keeps a legend as low as its panel."""
    place = axes.get_subplotspec()
    rows = place.get_gridspec().nrows if place else 1
    panel = _final_height(axes.figure.figure) / rows - _AROUND_PANEL_IN
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
