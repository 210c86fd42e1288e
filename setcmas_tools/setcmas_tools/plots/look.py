"""Look of plots: formats, palette, paper, fonts and sizes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from setcmas_simu.errors import SetcmasError

FORMATS = ('png', 'pdf', 'svg')
"""File formats by their usual endings: PNG at 150 dpi (in a paper 600), and vector graphics."""

PALETTES = ('robots', 'okabe-ito')
"""The robots' own colours, or those that colour-blind readers can tell apart as well."""

PAPERS = {'column': 3.5, 'page': 7.16}
"""Widths in inches of a figure in one column, and across both, of a two-column paper (IEEE)."""

FILMS = ('mp4', 'gif')
"""Kinds of films."""


@dataclass(frozen=True)
class PlotLook:
    """How plots look.

    Attributes:
        formats: Any of `formats.FORMATS`.
        palette: One of `formats.PALETTES`.
        paper: One of `formats.PAPERS`, for fonts and sizes of a printed paper.
        show: Whether to open the plots in windows too, until the user closes them.
    """

    formats: Sequence[str] = ('png',)
    palette: str = PALETTES[0]
    paper: str | None = None
    show: bool = False

    def check(self) -> None:
        """See that there are such formats and styles.

        Raises:
            SetcmasError: A choice is unknown.
        """
        for unknown in set(self.formats) - set(FORMATS):
            raise SetcmasError(
                f"format '{unknown}' is unknown; must be one of {', '.join(FORMATS)}"
            )
        check_style(self.palette, self.paper)


@dataclass(frozen=True)
class FilmLook:
    """How films look.

    Attributes:
        speed: How many times faster than the robots the film is.
        palette: One of `formats.PALETTES`.
        size: Width and height in pixels; odd ones are one less, since MP4 has even ones only.
        dpi: Dots an inch: with more of them letters and lines are larger.
    """

    speed: float = 1.0
    palette: str = PALETTES[0]
    size: tuple[int, int] = (640, 540)
    dpi: float = 100.0

    @property
    def inches(self) -> tuple[float, float]:
        """Width and height of the figure that has this size."""
        width, height = (2 * (side // 2) / self.dpi for side in self.size)
        return width, height


def check_style(palette: str, paper: str | None) -> None:
    """See that a style exists.

    Raises:
        SetcmasError: It does not.
    """
    if palette not in PALETTES:
        raise SetcmasError(f"palette '{palette}' is unknown; it must be {', '.join(PALETTES)}")
    if paper is not None and paper not in PAPERS:
        raise SetcmasError(f"paper '{paper}' is unknown; it must be {', '.join(PAPERS)}")


SCREEN: dict[str, Any] = {
    'figure.constrained_layout.use': True,
    'figure.dpi': 100,
    'savefig.dpi': 150,
    'font.size': 11,
    'axes.titlesize': 13,
    'axes.titlelocation': 'left',
    'axes.grid': True,
    'axes.axisbelow': True,
    'axes.spines.top': False,
    'axes.spines.right': False,
    'axes.edgecolor': '0.3',
    'grid.color': '0.9',
    'legend.fontsize': 10,
    'legend.frameon': False,
    'lines.linewidth': 1.6,
    'lines.markersize': 6.0,
    'lines.solid_capstyle': 'round',
    'lines.solid_joinstyle': 'round',
    'pdf.fonttype': 42,
    'svg.fonttype': 'path',
    'svg.hashsalt': 'setcmas',
}
"""On screens and slides."""

PAPER: dict[str, Any] = {
    'savefig.dpi': 600,
    'font.family': ['STIXGeneral', 'DejaVu Serif'],  # as Times; both come with matplotlib
    'mathtext.fontset': 'stix',
    'font.size': 8,
    'axes.labelsize': 8,
    'legend.fontsize': 7,
    'xtick.labelsize': 7,
    'ytick.labelsize': 7,
    'axes.linewidth': 0.6,
    'axes.labelpad': 2.0,
    'grid.linewidth': 0.5,
    'lines.linewidth': 0.9,
    'lines.markersize': 3.5,
    'legend.handlelength': 1.4,
    'legend.columnspacing': 1.0,
    'legend.handletextpad': 0.5,
    'legend.labelspacing': 0.25,
    'xtick.major.size': 2.5,
    'ytick.major.size': 2.5,
    'xtick.major.width': 0.6,
    'ytick.major.width': 0.6,
}
"""In a printed paper, on top of SCREEN: 8 pt letters at their true size."""
