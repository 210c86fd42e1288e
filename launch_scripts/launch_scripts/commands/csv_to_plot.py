"""Plot the trajectories of a run from its fleet.csv.

Examples:
  setcmas csv_to_plot out                        a run's folder; plots go to out/plots
  csv_to_plot out/csv -o figures --format pdf svg
  csv_to_plot out --show
"""

from __future__ import annotations

import argparse
from pathlib import Path

from launch_scripts.plot_options import add_format_argument


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        'run', type=Path, metavar='DIR', help='folder of a run, of its CSV files, or a fleet.csv'
    )
    parser.add_argument(
        '-o', '--output', type=Path, metavar='DIR', help='folder of the plots (default: DIR/plots)'
    )
    add_format_argument(parser)
    parser.add_argument('--show', action='store_true', help='open the plots in windows as well')


def main(args: argparse.Namespace) -> int:
    """Plot; returns the exit status."""
    from setcmas_tools.csv_to_plot import plot

    for path in plot(args.run, args.output, tuple(args.format), show=args.show):
        print(path)
    return 0
