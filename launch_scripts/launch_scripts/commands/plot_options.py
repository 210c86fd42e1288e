"""Options of plots and films."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from setcmas_simu.errors import SetcmasError
from setcmas_simu.options.group import ClashError, Options, option
from setcmas_simu.options.kinds import Kind, Number, OneOf, PathTo
from setcmas_simu.options.option import Form
from setcmas_tools.plots.look import FILMS, FORMATS, PALETTES, PAPERS

_LEAST_PX, _MOST_PX = 200, 7680

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


@dataclass(frozen=True)
class _Pixels(Kind):
    """Sizes of pictures in pixels, typed as 1280x720."""

    @property
    def must_be(self) -> str:
        """The bounds."""
        return f'WIDTHxHEIGHT in pixels from {_LEAST_PX} to {_MOST_PX}, such as 1280x720'

    def parse(self, text: str) -> tuple[int, ...] | str:
        """Return the size that a text tells."""
        found = re.fullmatch(r'(\d+)x(\d+)', text)
        size = (int(found[1]), int(found[2])) if found else ()
        return size if size and self.accepts(size) else text

    def accepts(self, value: Any) -> bool:
        """Return whether a value is a size within the bounds."""
        return isinstance(value, tuple) and all(_LEAST_PX <= side <= _MOST_PX for side in value)

    def text(self, value: Any) -> str:
        """Return the size as it is typed."""
        return f'{value[0]}x{value[1]}'


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
    """Whether there is a film, how fast and how large it is."""

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
    size: tuple[int, int] | None = option(
        _Pixels(metavar='WIDTHxHEIGHT'),
        'size of the film in pixels',
        default=None,
        default_text='640x540',
    )
    dpi: float | None = option(
        Number(least=50, most=600, metavar='N'),
        'dots an inch of the film: more of them make letters and lines larger',
        default=None,
        default_text='100',
    )

    def look(self) -> dict[str, Any]:
        """Return what is said of how the film looks."""
        told = {name: getattr(self, name) for name in ('speed', 'size', 'dpi')}
        return {name: value for name, value in told.items() if value is not None}

    def check(self) -> None:
        """See that what is said of a film has one."""
        if (told := self.look()) and not self.animate:
            raise ClashError('{} is that of a film; add {}', next(iter(told)), 'animate')
