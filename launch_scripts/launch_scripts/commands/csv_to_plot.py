"""Plot a run from its CSV files or its bag.

Examples:
  setcmas csv_to_plot out                        a run's folder; plots go to out/plots
  csv_to_plot lab.mcap                           a single bag; plots go to lab_plots
  csv_to_plot out/csv -o figures --format pdf svg
  csv_to_plot out --paper                        as PDF, 3.5 inches wide with 8 pt text
  csv_to_plot out --animate --speed 4            also a video, four times as fast
  csv_to_plot out --animate mp4 --size 1920x1080 --dpi 200
"""

from __future__ import annotations

import argparse
from pathlib import Path

from launch_scripts.commands.plot_options import BEST, FilmOptions, StyleOptions, add_run_argument
from launch_scripts.terminal import warner

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
        film_look = FilmSettings(film.speed, style.palette, film.size, film.dpi)
        print(animate(run, folder, kind, film_look))
    return 0
