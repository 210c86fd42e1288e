"""Convert a bag to a CSV file per topic, and fleet.csv for the whole fleet.

Reads rosbag2 folders (mcap or sqlite3), single .mcap and .db3 files, and ROS 1 .bag files, with
any message types. From a truncated bag it converts all complete messages.

Examples:
  setcmas bag_to_csv out/bag
  bag_to_csv lab.bag -o csv
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

from setcmas_simu.options.group import Options, option
from setcmas_simu.options.kinds import PathTo


@dataclass(frozen=True, kw_only=True)
class TableFolderOptions(Options):
    """Destination of the CSV files."""

    output: Path | None = option(
        PathTo(metavar='DIR'),
        'folder of the CSV files',
        default=None,
        default_text='csv next to a folder named bag, else BAG_csv',
        short='-o',
    )


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument('bag', type=Path, metavar='BAG', help='folder or file of the bag')
    TableFolderOptions.add_to(parser)


def main(args: argparse.Namespace) -> int:
    """Convert; return the exit status."""
    from setcmas_tools.run.bag_conversion import convert

    report = convert(args.bag, args.output)
    print(report)
    return 0
