"""Plot a run from its CSV files or its bag.

Examples:
  setcmas csv_to_plot out                        a run's folder; plots go to out/plots
  csv_to_plot lab.mcap                           a single bag; plots go to lab_plots
  csv_to_plot out/csv -o figures --format pdf svg
  csv_to_plot out --paper                        as PDF, 3.5 inches wide with 8 pt text
  csv_to_plot out --animate --speed 4            also a video, four times as fast
  csv_to_plot out --animate mp4
"""

from __future__ import annotations

import argparse
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from launch_scripts.terminal import warn, warner
from setcmas_simu.errors import SetcmasError
from setcmas_simu.option_groups import ClashError, Form, Options, option
from setcmas_simu.option_kinds import Number, OneOf
from setcmas_tools.page.browser import palette_option
from setcmas_tools.plots.plot_settings import FILMS, FORMATS, PAPERS, FilmSettings, PlotSettings
from setcmas_tools.run.run_folder import RunFolder

if TYPE_CHECKING:
    from setcmas_tools.run.run import Run

_warn = warner('csv_to_plot')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    add_run_argument(parser)
    folder = "folder of the plots (default: plots in a run's folder, BAG_plots next to a bag)"
    parser.add_argument('-o', '--output', type=Path, metavar='DIR', help=folder)
    StyleOptions.add_to(parser)
    FilmOptions.add_to(parser)
    parser.add_argument('--show', action='store_true', help='open the plots in windows')


def main(args: argparse.Namespace) -> int:
    """Plot; return the exit status."""
    from setcmas_tools.plots.plot import plot
    from setcmas_tools.plots.plot_settings import FilmSettings, PlotSettings
    from setcmas_tools.run.run import Run
    from setcmas_tools.run.run_folder import find_run

    style, film = StyleOptions.of(args), FilmOptions.of(args)
    folder = args.output or find_run(args.run).plots
    run = Run.load(args.run, _warn)
    look = PlotSettings(style.formats, style.palette, style.paper, args.show)
    # A video takes time and may fail, so report the plots first.
    print(*plot(run, folder, look, _warn), sep='\n', flush=True)
    if film.animate:
        from setcmas_tools.plots.film import animate

        kind = None if film.animate == BEST else film.animate
        film_look = FilmSettings(film.speed, style.palette)
        print(animate(run, folder, kind, film_look))
    return 0


def add_run_argument(parser: argparse.ArgumentParser) -> None:
    """Add the run that a verb reads."""
    purpose = "a run's folder, a folder of CSV files, a fleet.csv, or a bag"
    parser.add_argument('run', type=Path, metavar='DIR', help=purpose)


def print_evaluation(
    args: argparse.Namespace, folder: RunFolder, run: Run, earlier: Path | None
) -> str:
    """Plot and measure a run, and compare it with an earlier one; return its folders as text."""
    # Imported late: help texts and the start of robots need not wait for numpy.
    from setcmas_tools.measures.metrics import measure, write_yaml

    figures: list[Path] = []
    if args.plots:
        from setcmas_tools.plots.plot import plot  # late: matplotlib loads slowly

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


@dataclass(frozen=True, kw_only=True)
class PaletteOptions(Options):
    """Colours of the robots."""

    palette: str = palette_option()


@dataclass(frozen=True, kw_only=True)
class FormatOptions(PaletteOptions):
    """Formats and colours of plots."""

    format: tuple[str, ...] = option(
        OneOf(FORMATS), 'formats of the plots', default=('png',), form=Form.SEVERAL
    )


@dataclass(frozen=True, kw_only=True)
class StyleOptions(PaletteOptions):
    """Formats, colours and sizes of plots."""

    format: tuple[str, ...] | None = option(
        OneOf(FORMATS),
        'formats of the plots',
        default=None,
        default_text='png, with --paper pdf',
        form=Form.SEVERAL,
    )
    paper: str | None = option(
        OneOf(tuple(PAPERS)),
        'for print: column (3.5 inches wide; same as --paper alone) or page (7.16 inches wide)',
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
        OneOf((BEST, *FILMS)),
        'also write a video: mp4 (needs ffmpeg), gif, or best: mp4 if possible, else gif',
        default=None,
        alone=BEST,
    )
    speed: float = option(
        Number(above=0, finite=True, metavar='TIMES'),
        'playback speed, in multiples of real time',
        default=FilmSettings.speed,
    )

    def check(self) -> None:
        """Check that options of films come with --animate."""
        if not self.animate and (changed := list(self.changed())):
            raise ClashError('{} is for videos; add {}', changed[0], 'animate')
