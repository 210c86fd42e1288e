"""Record topics into a rosbag2 bag until Ctrl-C.

By default it records every topic of its namespace, including those that appear later. The bag
stays readable even if the recorder is killed.

Examples:
  setcmas record                                 writes to bag_<date and time>
  setcmas record -o out/bag
  setcmas record --topics /tb3_1/odom /tb3_1/cmd_vel
  setcmas record --ros-args -r __ns:=/a          the fleet in namespace /a
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from launch_scripts.environment import require_ros
from launch_scripts.processes import RECORDER, add_ros_arguments
from launch_scripts.supervisor import run_node
from setcmas_simu.errors import SetcmasError
from setcmas_tools.bags.recording_options import RecorderOptions


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    RecorderOptions.add_to(parser, output=None)
    add_ros_arguments(parser)


def main(args: argparse.Namespace) -> int:
    """Record until Ctrl-C; return the exit status."""
    args.output = args.output or Path(time.strftime('bag_%Y%m%d-%H%M%S'))
    options = RecorderOptions.of(args)
    if options.output.exists():
        raise SetcmasError(f"output '{options.output}' already exists; choose another folder")
    require_ros()
    return run_node(args, RECORDER, options.arguments())
