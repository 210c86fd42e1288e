"""Play a recording: publish its messages in real time for the page, RViz and recorders.

It plays poses, communication and drawings only: no robot moves because of a recording.
Playback does not start while one of the recorded robots is running, and stops when one starts.

Examples:
  setcmas play out
  setcmas play out/bag --rate 5
"""

from __future__ import annotations

import argparse
from pathlib import Path

from launch_scripts.environment import require_ros
from launch_scripts.processes import PLAYER, add_ros_arguments
from launch_scripts.supervisor import run_node
from setcmas_tools.bags.recording_options import PlayerOptions


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument('bag', type=Path, metavar='BAG', help='folder of a run, or a rosbag2 bag')
    PlayerOptions.add_to(parser)
    add_ros_arguments(parser)


def main(args: argparse.Namespace) -> int:
    """Play until the end or Ctrl-C; return the exit status."""
    options = PlayerOptions.of(args)
    require_ros()
    return run_node(args, PLAYER, [str(args.bag), *options.arguments()], may_end=True)
