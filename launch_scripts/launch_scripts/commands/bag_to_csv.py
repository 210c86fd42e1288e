"""Convert a bag to a CSV file for each topic, and fleet.csv for the whole fleet.

Accepted are rosbag2 folders (mcap or sqlite3), lone .mcap and .db3 files, and ROS 1 .bag files,
with any message types. A bag that was cut short gives what it holds.

Examples:
  setcmas bag_to_csv out/bag
  bag_to_csv somebody_elses.bag -o csv
"""

from __future__ import annotations

import argparse
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument('bag', type=Path, metavar='BAG', help='folder or file of the bag')
    parser.add_argument(
        '-o',
        '--output',
        type=Path,
        metavar='DIR',
        help='folder of the CSV files (default: csv beside a folder named bag, else BAG_csv)',
    )


def main(args: argparse.Namespace) -> int:
    """Convert; returns the exit status."""
    from setcmas_tools.tables.convert import convert

    report = convert(args.bag, args.output)
    print(report)
    return 0
