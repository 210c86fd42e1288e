"""Options of plots and films."""

from __future__ import annotations

import argparse
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from setcmas_simu.errors import SetcmasError
from setcmas_simu.options.group import ClashError, Options, option
from setcmas_simu.options.kinds import Kind, Number, OneOf, PathTo
from setcmas_simu.options.option import Form
from setcmas_tools.page.browser import palette_option
from setcmas_tools.plots.look import FILMS, FORMATS, PAPERS

_LEAST_PX, _MOST_PX = 200, 7680


def add_run_argument(parser: argparse.ArgumentParser) -> None:
    """Add the run that a verb reads."""
    parser.add_argument(
        'run',
        type=Path,
        metavar='DIR',
        help="a run's folder, a folder of CSV files, a fleet.csv, or a bag",
    )


BEST = 'best'
"""The best kind of film on this machine."""


@dataclass(frozen=True)
class _OneOfBeforeFolder(OneOf):
    """Values of options that might swallow the folder after them."""

    def check(self, name: str, value: Any) -> None:
        """Check that a value is accepted."""
        if isinstance(value, str) and not self.accepts(value) and Path(value).exists():
            raise SetcmasError(
                f"{name} is '{value}'; it must be {self.must_be}; put the folder to plot first"
            )
        super().check(name, value)


@dataclass(frozen=True)
class _Pixels(Kind):
    """Sizes of pictures in pixels, such as 1280x720."""

    @property
    def must_be(self) -> str:
        """The bounds."""
        return f'WIDTHxHEIGHT in pixels from {_LEAST_PX} to {_MOST_PX}, such as 1280x720'

    def parse(self, text: str) -> tuple[int, ...] | str:
        """Return the size in a text."""
        found = re.fullmatch(r'(\d+)x(\d+)', text)
        size = (int(found[1]), int(found[2])) if found else ()
        return size if size and self.accepts(size) else text

    def accepts(self, value: Any) -> bool:
        """Return whether a value is a size within the bounds."""
        return isinstance(value, tuple) and all(_LEAST_PX <= side <= _MOST_PX for side in value)

    def text(self, value: Any) -> str:
        """Return the size as text."""
        return f'{value[0]}x{value[1]}'


@dataclass(frozen=True, kw_only=True)
class FormatOptions(Options):
    """Formats and colours of plots."""

    format: tuple[str, ...] = option(
        _OneOfBeforeFolder(FORMATS),
        'formats of the plots',
        default=('png',),
        form=Form.SEVERAL,
    )
    palette: str = palette_option()


@dataclass(frozen=True, kw_only=True)
class PlotFolderOptions(Options):
    """Destination of plots."""

    output: Path | None = option(
        PathTo(metavar='DIR'),
        'folder of the plots',
        default=None,
        default_text="plots in a run's folder, BAG_plots next to a single bag",
        short='-o',
    )


@dataclass(frozen=True, kw_only=True)
class StyleOptions(Options):
    """Colours and sizes of plots; PDF by default for --paper."""

    format: tuple[str, ...] | None = option(
        _OneOfBeforeFolder(FORMATS),
        'formats of the plots',
        default=None,
        default_text='png',
        form=Form.SEVERAL,
    )
    palette: str = palette_option()
    paper: str | None = option(
        _OneOfBeforeFolder(tuple(PAPERS)),
        'for print, as PDF: 3.5 inches wide (column, the default) or 7.16 inches (page)',
        default=None,
        alone='column',
    )

    @property
    def formats(self) -> tuple[str, ...]:
        """The formats to write."""
        return self.format or (('pdf',) if self.paper else ('png',))


@dataclass(frozen=True, kw_only=True)
class FilmOptions(Options):
    """Options of films."""

    animate: str | None = option(
        _OneOfBeforeFolder((BEST, *FILMS)),
        'also write a video: mp4 (needs ffmpeg) or gif',
        default=None,
        default_text='mp4 if possible',
        alone=BEST,
    )
    speed: float | None = option(
        Number(above=0, finite=True, metavar='TIMES'),
        'playback speed, in multiples of real time',
        default=None,
        default_text='1',
    )
    size: tuple[int, int] | None = option(
        _Pixels(metavar='WIDTHxHEIGHT'),
        'size of the video in pixels',
        default=None,
        default_text='640x540',
    )
    dpi: float | None = option(
        Number(least=50, most=600, metavar='N'),
        'resolution in dots per inch: higher values enlarge text and lines',
        default=None,
        default_text='100',
    )

    def look(self) -> dict[str, Any]:
        """Return the options of the film's appearance."""
        given = {name: getattr(self, name) for name in ('speed', 'size', 'dpi')}
        return {name: value for name, value in given.items() if value is not None}

    def check(self) -> None:
        """Check that options of films come with --animate."""
        if (given := self.look()) and not self.animate:
            raise ClashError('{} is for videos; add {}', next(iter(given)), 'animate')
