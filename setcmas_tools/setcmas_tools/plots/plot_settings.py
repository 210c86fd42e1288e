"""Settings of plots and films: formats, palette, paper and sizes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.palettes import PALETTES

FORMATS = ('png', 'pdf', 'svg')
"""File formats by file ending: PNG at 150 dpi (600 on paper), and vector graphics."""

PAPERS = {'column': 3.5, 'page': 7.16}
"""Widths in inches of a one-column and a two-column figure in a two-column paper (IEEE)."""

FILMS = ('mp4', 'gif')
"""Kinds of films."""


@dataclass(frozen=True)
class PlotSettings:
    """Appearance of plots.

    Attributes:
        formats: Any of `FORMATS`.
        palette: One of `palettes.PALETTES`.
        paper: One of `PAPERS`, for fonts and sizes of a printed paper.
        show: Whether to open the plots in windows until the user closes them.
    """

    formats: Sequence[str] = ('png',)
    palette: str = PALETTES[0]
    paper: str | None = None
    show: bool = False

    def check(self) -> None:
        """Check formats and styles, or raise SetcmasError."""
        for unknown in set(self.formats) - set(FORMATS):
            raise SetcmasError(f"unknown format '{unknown}'; must be one of {', '.join(FORMATS)}")
        check_style(self.palette, self.paper)


@dataclass(frozen=True)
class FilmSettings:
    """Appearance of films.

    Attributes:
        speed: Playback speed in multiples of real time.
        palette: One of `palettes.PALETTES`.
        size: Width and height in pixels; odd sizes are reduced by one for MP4.
        dpi: Dots per inch; higher values enlarge text and lines.
    """

    speed: float = 1.0
    palette: str = PALETTES[0]
    size: tuple[int, int] = (640, 540)
    dpi: float = 100.0

    @property
    def inches(self) -> tuple[float, float]:
        """Width and height of a figure of this size."""
        width, height = (2 * (side // 2) / self.dpi for side in self.size)
        return width, height


def check_style(palette: str, paper: str | None) -> None:
    """Check that a style exists; raise SetcmasError otherwise."""
    if palette not in PALETTES:
        raise SetcmasError(f"unknown palette '{palette}'; must be {', '.join(PALETTES)}")
    if paper is not None and paper not in PAPERS:
        raise SetcmasError(f"unknown paper '{paper}'; must be {', '.join(PAPERS)}")
