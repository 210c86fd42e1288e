"""Show the robots that are running, simulated or real, on a page in the browser until Ctrl-C.

It shows poses, trails, drawings of control scripts and communication, and lets you pause, start
and reset the robots.

Examples:
  setcmas view
  setcmas view --port 9000
  setcmas view --host 0.0.0.0 --read-only        for others on the network, to look at only
  setcmas view --write-rviz fleet.rviz --robots 1-5
"""

from __future__ import annotations

import argparse

from launch_scripts.options.rviz import add_rviz_file_arguments, shown_robots, write_config
from launch_scripts.options.view_options import browser_command, has_viser
from launch_scripts.processes.environment import require_ros
from launch_scripts.processes.foreground import run_in_foreground
from launch_scripts.processes.node_arguments import node_arguments
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import format_robots
from setcmas_tools.view.page.browser_options import INSTALL_VISER, add_browser_arguments

_OPTIONS = ('host', 'port')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    add_browser_arguments(parser.add_argument_group('page'))
    add_rviz_file_arguments(parser)


def main(args: argparse.Namespace) -> int:
    """Show the robots until Ctrl-C; returns the exit status."""
    if args.write_rviz:
        robots = shown_robots(args)
        write_config(args.write_rviz, robots, args.experiment)
        print(f'rviz2 -d {args.write_rviz} shows robots {format_robots(robots)}')
        return 0
    if args.robots or args.experiment:
        option = '--robots' if args.robots else '--experiment'
        raise SetcmasError(f'{option} is for the file of --write-rviz; the page shows all robots')
    require_ros()
    if not has_viser():
        raise SetcmasError(f'viser is needed and is missing: {INSTALL_VISER}')
    arguments = node_arguments(args, _OPTIONS) + (['--read-only'] if args.read_only else [])
    return run_in_foreground('view', browser_command(arguments))
