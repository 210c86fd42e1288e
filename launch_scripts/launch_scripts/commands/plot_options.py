"""Options of plots and films."""

from __future__ import annotations

import argparse
import re
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from launch_scripts.terminal import warn
from setcmas_simu.errors import SetcmasError
from setcmas_simu.option_kinds import Kind, Number, OneOf
from setcmas_simu.options import ClashError, Form, Options, option
from setcmas_tools.page.browser import palette_option
from setcmas_tools.plots.plot_settings import FILMS, FORMATS, PAPERS, FilmSettings, PlotSettings
from setcmas_tools.run.run_folder import RunFolder

if TYPE_CHECKING:
    from setcmas_tools.run.run import Run

_LEAST_PX, _MOST_PX = 200, 7680


def add_run_argument(parser: argparse.ArgumentParser) -> None:
    """Add the run that a verb reads."""
    purpose = "a run's folder, a folder of CSV files, a fleet.csv, or a bag"
    parser.add_argument('run', type=Path, metavar='DIR', help=purpose)


def print_evaluation(
    args: argparse.Namespace, folder: RunFolder, run: Run, earlier: Path | None
) -> str:
    """Plot and measure a run, and compare it with an earlier one; return its folders as text."""
    # Imported late: help texts, and the start of the robots, do not wait for numpy.
    from setcmas_tools.measures.metrics import measure, write_yaml

    figures: list[Path] = []
    if args.plots:
        from setcmas_tools.plots.plot import plot  # who draws nothing does not wait for matplotlib

        figures = plot(run, folder.plots, PlotSettings(tuple(args.format), args.palette), warn)
    metrics = measure(run, warn)
    write_yaml(metrics, folder.metrics)
    with suppress(OSError):  # the terminal may be closed; the work is done
        print(metrics)
        if earlier:
            print(_comparison(folder.path, earlier))
    return folder.summary(len(figures))


def _comparison(folder: Path, earlier: Path) -> str:
    from setcmas_tools.measures.comparison import comparison_line

    try:
        return comparison_line(folder, earlier)
    except SetcmasError as error:  # the earlier run may have no results
        return f'not compared with {earlier}: {error}'


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

    MUST_BE = f'WIDTHxHEIGHT in pixels from {_LEAST_PX} to {_MOST_PX}, such as 1280x720'

    def parse(self, text: str) -> tuple[int, ...] | str:
        """Return the size in a text."""
        found = re.fullmatch(r'(\d+)x(\d+)', text)
        size = (int(found[1]), int(found[2])) if found else ()
        return size if size and self.accepts(size) else text

    def accepts(self, value: Any) -> bool:
        """Return whether a value is a size within the bounds."""
        return isinstance(value, tuple) and all(_LEAST_PX <= side <= _MOST_PX for side in value)


@dataclass(frozen=True, kw_only=True)
class PaletteOptions(Options):
    """Colours of the robots."""

    palette: str = palette_option()


@dataclass(frozen=True, kw_only=True)
class FormatOptions(PaletteOptions):
    """Formats and colours of plots."""

    format: tuple[str, ...] = option(
        _OneOfBeforeFolder(FORMATS), 'formats of the plots', default=('png',), form=Form.SEVERAL
    )


@dataclass(frozen=True, kw_only=True)
class StyleOptions(PaletteOptions):
    """Formats, colours and sizes of plots."""

    format: tuple[str, ...] | None = option(
        _OneOfBeforeFolder(FORMATS),
        'formats of the plots',
        default=None,
        default_text='png, with --paper pdf',
        form=Form.SEVERAL,
    )
    paper: str | None = option(
        _OneOfBeforeFolder(tuple(PAPERS)),
        'for print: column (3.5 inches wide; --paper alone means this) or page (7.16 inches)',
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
        'also write a video: mp4 (needs ffmpeg), gif, or best: mp4 if possible, else gif',
        default=None,
        alone=BEST,
    )
    speed: float = option(
        Number(above=0, finite=True, metavar='TIMES'),
        'playback speed, in multiples of real time',
        default=FilmSettings.speed,
    )
    size: tuple[int, int] = option(
        _Pixels(metavar='WIDTHxHEIGHT'),
        'size of the video in pixels',
        default=FilmSettings.size,
        default_text='x'.join(map(str, FilmSettings.size)),
    )
    dpi: float = option(
        Number(least=50, most=600, metavar='N'),
        'resolution in dots per inch: higher values enlarge text and lines',
        default=FilmSettings.dpi,
    )

    def check(self) -> None:
        """Check that options of films come with --animate."""
        if not self.animate and (changed := list(self.changed())):
            raise ClashError('{} is for videos; add {}', changed[0], 'animate')
