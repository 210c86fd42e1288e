"""Plot the trajectories of a run from its fleet.csv.

Examples:
  setcmas csv_to_plot out                        a run's folder; plots go to out/plots
  csv_to_plot out/csv -o figures --format pdf svg
  csv_to_plot out --palette okabe-ito --show     for colour-blind readers
  csv_to_plot out --paper column                 as PDF, 3.5 in wide with 8 pt letters
"""

from __future__ import annotations

import argparse
from pathlib import Path

from launch_scripts.plot_options import add_format_argument, add_style_arguments


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        'run', type=Path, metavar='DIR', help='folder of a run, of its CSV files, or a fleet.csv'
    )
    parser.add_argument(
        '-o', '--output', type=Path, metavar='DIR', help='folder of the plots (default: DIR/plots)'
    )
    add_format_argument(parser)
    add_style_arguments(parser)
    parser.add_argument('--show', action='store_true', help='open the plots in windows as well')


def main(args: argparse.Namespace) -> int:
    """Plot; returns the exit status."""
    from setcmas_tools.csv_to_plot import plot

    formats = args.format or (['pdf'] if args.paper else ['png'])
    paths = plot(
        args.run,
        args.output,
        tuple(formats),
        show=args.show,
        palette=args.palette,
        paper=args.paper,
    )
    for path in paths:
        print(path)
    return 0
