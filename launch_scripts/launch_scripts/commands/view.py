"""Show the robots that are running, simulated or real, on a page in the browser until Ctrl-C.

It shows poses, trails, drawings of control scripts and communication, and lets you pause, start
and reset the robots.

Examples:
  setcmas view
  setcmas view --port 9000
  setcmas view --host 0.0.0.0 --read-only        for others on the network, to look at only
  setcmas view --write-rviz fleet.rviz --robots 1-5
  setcmas view out --rerun                       writes out/run.rrd, which the program rerun shows
"""

from __future__ import annotations

import argparse
from pathlib import Path

from launch_scripts.options.rerun import BESIDE_RUN, write_for_rerun
from launch_scripts.options.rviz import RvizFileOptions, shown_robots, write_config
from launch_scripts.options.view_options import browser_command, has_viser
from launch_scripts.processes.environment import require_ros
from launch_scripts.processes.foreground import run_in_foreground
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.options.group import spelled
from setcmas_tools.view.page.browser_options import INSTALL_VISER, BrowserOptions


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        'run',
        nargs='?',
        type=Path,
        metavar='RUN',
        help='folder of a run, of its CSV files, a fleet.csv, or a bag, for --rerun',
    )
    BrowserOptions.add_to(parser, without=('operator',))
    RvizFileOptions.add_to(parser)
    parser.add_argument(
        '--rerun',
        nargs='?',
        const=BESIDE_RUN,
        type=Path,
        metavar='FILE.rrd',
        help='write RUN as a file for the program rerun (default: run.rrd in its folder)',
    )


def main(args: argparse.Namespace) -> int:
    """Show the robots until Ctrl-C; returns the exit status."""
    if args.rerun:
        return write_for_rerun(args.run, args.rerun)
    if args.run:
        raise SetcmasError(
            f"'{args.run}' is a run that is over: add --rerun to write a file of it"
        )
    rviz = RvizFileOptions.of(args)
    if rviz.write_rviz:
        robots = shown_robots(rviz.robots)
        write_config(rviz.write_rviz, robots, rviz.experiment)
        print(f'rviz2 -d {rviz.write_rviz} shows {robots_in_words(robots)}')
        return 0
    if surplus := rviz.changed():
        raise SetcmasError(
            f'{spelled(surplus[0])} is for the file of --write-rviz; the page shows all robots'
        )
    require_ros()
    if not has_viser():
        raise SetcmasError(f'viser is needed and is missing: {INSTALL_VISER}')
    return run_in_foreground('view', browser_command(BrowserOptions.of(args).arguments()))
