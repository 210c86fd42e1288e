"""Options of plots and films."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from setcmas_simu.errors import SetcmasError
from setcmas_simu.options.group import ClashError, Options, option
from setcmas_simu.options.kinds import Number, OneOf, PathTo
from setcmas_simu.options.option import Form
from setcmas_tools.plots.looks.formats import FILMS, FORMATS, PALETTES, PAPERS

BEST = 'best'
"""The kind of film that is the best on this machine."""


@dataclass(frozen=True)
class _OneOfBesideFolder(OneOf):
    """Words of options that would take a folder behind them for their value."""

    def check(self, name: str, value: Any) -> None:
        """See that a value is one of the words."""
        if isinstance(value, str) and not self.accepts(value) and Path(value).exists():
            raise SetcmasError(
                f"{name} is '{value}'; it must be {self.must_be}; put what to plot first"
            )
        super().check(name, value)


@dataclass(frozen=True, kw_only=True)
class FormatOptions(Options):
    """File formats of plots."""

    format: tuple[str, ...] = option(
        _OneOfBesideFolder(FORMATS),
        'formats of the plots',
        default=('png',),
        form=Form.SEVERAL,
    )


@dataclass(frozen=True, kw_only=True)
class PlotFolderOptions(Options):
    """Where plots go."""

    output: Path | None = option(
        PathTo(metavar='DIR'),
        'folder of the plots',
        default=None,
        default_text='plots in the folder of a run, BAG_plots beside a bag alone',
        short='-o',
    )


@dataclass(frozen=True, kw_only=True)
class StyleOptions(Options):
    """Colours and sizes of plots; in a paper they are PDF unless told otherwise."""

    format: tuple[str, ...] | None = option(
        _OneOfBesideFolder(FORMATS),
        'formats of the plots',
        default=None,
        default_text='png',
        form=Form.SEVERAL,
    )
    palette: str = option(
        OneOf(PALETTES),
        "colours of the robots, or Okabe and Ito's for colour-blind readers",
        default=PALETTES[0],
    )
    paper: str | None = option(
        _OneOfBesideFolder(tuple(PAPERS)),
        'for print in two columns, as PDF: 3.5 in wide (column, the default) or 7.16 (page)',
        default=None,
        alone='column',
    )

    @property
    def formats(self) -> tuple[str, ...]:
        """The formats to write."""
        return self.format or (('pdf',) if self.paper else ('png',))


@dataclass(frozen=True, kw_only=True)
class FilmOptions(Options):
    """Whether there is a film, and how fast it is."""

    animate: str | None = option(
        _OneOfBesideFolder((BEST, *FILMS)),
        'write a film as well: mp4 (needs ffmpeg) or gif',
        default=None,
        default_text='the first that works',
        alone=BEST,
    )
    speed: float | None = option(
        Number(above=0, finite=True, metavar='TIMES'),
        'how many times faster than the robots the film is',
        default=None,
        default_text='1',
    )

    def check(self) -> None:
        """See that a speed has a film."""
        if self.speed and not self.animate:
            raise ClashError('{} is that of a film; add {}', 'speed', 'animate')
