"""Plot a run from its CSV files or its bag.

Examples:
  setcmas csv_to_plot out                        a run's folder; plots go to out/plots
  csv_to_plot lab.mcap                           a single bag; plots go to lab_plots
  csv_to_plot out/csv -o figures --format pdf svg
  csv_to_plot out --animate --speed 4            also a video, four times as fast
  csv_to_plot out --animate mp4
"""

from __future__ import annotations

import argparse
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from launch_scripts.terminal import warn, warner
from setcmas_simu.errors import SetcmasError
from setcmas_tools.plots.plot_options import BEST, FilmOptions, PlotOptions
from setcmas_tools.run.run_folder import RunFolder

if TYPE_CHECKING:
    from setcmas_tools.run.run import Run

_warn = warner('csv_to_plot')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    add_run_argument(parser)
    folder = "folder of the plots (default: plots in a run's folder, BAG_plots next to a bag)"
    parser.add_argument('-o', '--output', type=Path, metavar='DIR', help=folder)
    PlotOptions.add_to(parser)
    FilmOptions.add_to(parser)


def main(args: argparse.Namespace) -> int:
    """Plot; return the exit status."""
    from setcmas_tools.plots.plot import plot
    from setcmas_tools.run.run import Run
    from setcmas_tools.run.run_folder import find_run

    look, film = PlotOptions.of(args), FilmOptions.of(args)
    folder = args.output or find_run(args.run).plots
    run = Run.load(args.run, _warn)
    # A video takes time and may fail, so report the plots first.
    print(*plot(run, folder, look, _warn), sep='\n', flush=True)
    if film.animate:
        from setcmas_tools.plots.film import animate

        kind = None if film.animate == BEST else film.animate
        print(animate(run, folder, kind, film.speed))
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

        figures = plot(run, folder.plots, PlotOptions.of(args), warn)
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
