"""Show running robots, or a finished run, on a page in the browser until Ctrl-C.

The page shows poses, trails, drawings of control scripts and communication, with a time bar and
charts. Its buttons pause, start and reset simulated robots, and pause and stop real ones. Select a
robot of a finished run to see the velocity that its law returned. A second run is drawn over the
first one, with their differences.

Examples:
  setcmas view
  setcmas view out                               a finished run: its folder, a bag, or a fleet.csv
  setcmas view experiment simulation             two runs, the second as ghosts
  setcmas view --host 0.0.0.0 --read-only        for others on the network, without buttons
"""

from __future__ import annotations

import argparse
from pathlib import Path

from launch_scripts.commands.view_options import browser_command
from launch_scripts.environment import require_ros
from launch_scripts.processes import add_ros_arguments, ros_arguments
from launch_scripts.supervisor import run_in_foreground
from launch_scripts.terminal import warn
from setcmas_simu.errors import SetcmasError
from setcmas_tools.page.browser import BrowserOptions


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    runs = 'a finished run, or two: folder, bag or fleet.csv (default: the running robots)'
    parser.add_argument('runs', nargs='*', type=Path, metavar='RUN', help=runs)
    BrowserOptions.add_to(parser)
    add_ros_arguments(parser)


def main(args: argparse.Namespace) -> int:
    """Show the robots until Ctrl-C; return the exit status."""
    browser = BrowserOptions.of(args)
    if len(args.runs) > 2:
        raise SetcmasError(f'{len(args.runs)} runs given; name one or two')
    if not args.runs:
        require_ros()
        command = browser_command(browser.arguments() + ros_arguments(args))
        return run_in_foreground('view', command)
    from setcmas_tools.page.report_file import loaded_pair
    from setcmas_tools.page.viewer import show_runs  # it needs matplotlib

    show_runs(loaded_pair(args.runs, warn), browser)
    return 0
