"""Convert a bag to a CSV file per topic, and fleet.csv for the whole fleet.

Reads rosbag2 folders (mcap or sqlite3), single .mcap and .db3 files, and ROS 1 .bag files, with
messages of any type. If an mcap bag was cut short, it reads what is there, and a message says how
much.

Examples:
  setcmas bag_to_csv out/bag
  bag_to_csv lab.bag -o csv
"""

from __future__ import annotations

import argparse
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument('bag', type=Path, metavar='BAG', help='folder or file of the bag')
    folder = 'folder of the CSV files (default: csv next to a folder named bag, else BAG_csv)'
    parser.add_argument('-o', '--output', type=Path, metavar='DIR', help=folder)


def main(args: argparse.Namespace) -> int:
    """Convert; return the exit status."""
    from setcmas_tools.run.bag_conversion import convert

    print(convert(args.bag, args.output))
    return 0
