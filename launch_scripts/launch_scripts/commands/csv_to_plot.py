"""Plot the trajectories of a run from its fleet.csv.

Examples:
  setcmas csv_to_plot out                        a run's folder; plots go to out/plots
  csv_to_plot out/csv -o figures --format pdf svg
  csv_to_plot out --palette okabe-ito --show     for colour-blind readers
  csv_to_plot out --paper                        as PDF, 3.5 in wide with 8 pt letters
  csv_to_plot out --animate --speed 4            a film too, four times as fast
"""

from __future__ import annotations

import argparse
from pathlib import Path

from launch_scripts.options.plot_options import BEST, FilmOptions, StyleOptions


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        'run', type=Path, metavar='DIR', help='folder of a run, of its CSV files, or a fleet.csv'
    )
    parser.add_argument(
        '-o', '--output', type=Path, metavar='DIR', help='folder of the plots (default: DIR/plots)'
    )
    StyleOptions.add_to(parser)
    FilmOptions.add_to(parser)
    parser.add_argument('--show', action='store_true', help='open the plots in windows as well')


def main(args: argparse.Namespace) -> int:
    """Plot; returns the exit status."""
    from setcmas_tools.plots.plot import plot

    style, film = StyleOptions.of(args), FilmOptions.of(args)
    paths = plot(
        args.run,
        args.output,
        style.formats,
        show=args.show,
        palette=style.palette,
        paper=style.paper,
    )
    print('\n'.join(map(str, paths)), flush=True)  # a film may take its time, or fail
    if film.animate:
        from setcmas_tools.films.film import animate

        kind = None if film.animate == BEST else film.animate
        speed = film.speed or 1.0
        print(animate(args.run, args.output, kind, speed, palette=style.palette))
    return 0
