"""Play a recording: publish its messages in real time for the page, RViz and recorders.

Commands are never played (cmd_vel, pause, reset, joysticks): no robot moves because of a
recording. Playback does not start while one of the recorded robots is running, and stops when
one starts.

Examples:
  setcmas play out
  setcmas play out/bag --rate 5
"""

from __future__ import annotations

import argparse
from pathlib import Path

from launch_scripts.environment import local_environment, require_ros
from launch_scripts.processes import PLAYER, add_ros_arguments, node_command, ros_arguments
from launch_scripts.supervisor import Supervisor
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
    arguments = [str(args.bag), *options.arguments(), *ros_arguments(args)]
    command = node_command(PLAYER, arguments)
    with Supervisor(local_environment()) as supervisor:
        return supervisor.run_to_end(supervisor.start('play', command))
