"""Look of plots: formats, palette and paper, known before matplotlib is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from setcmas_simu.errors import SetcmasError
from setcmas_tools.plots.looks.formats import FORMATS, PALETTES, PAPERS


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
