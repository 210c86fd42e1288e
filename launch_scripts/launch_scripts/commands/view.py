"""Show robots that run, or those of a run that is over, on a page in the browser until Ctrl-C.

It shows poses, trails, drawings of control scripts and communication. Robots that run can be
paused, started and reset. A run that is over has a time bar and charts; click a robot to see what
it knew and what its law wanted. A second run is shown over the first one, with their difference.

Examples:
  setcmas view
  setcmas view --port 9000
  setcmas view out                               a run: its folder, a bag, or a fleet.csv
  setcmas view out --at 12.5
  setcmas view experiment simulation             two runs, the second one as ghosts
  setcmas view --host 0.0.0.0 --read-only        for others on the network, to look at only
  setcmas view --write-rviz fleet.rviz --robots 1-5
"""

from __future__ import annotations

import argparse
from pathlib import Path

from launch_scripts.commands.view_options import browser_command, has_viser
from launch_scripts.processes.environment import require_ros
from launch_scripts.processes.foreground import run_in_foreground
from launch_scripts.processes.rviz import RvizFileOptions, shown_robots, write_config
from launch_scripts.terminal.terminal_output import warn
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.options.group import spelled
from setcmas_tools.run.run import Run
from setcmas_tools.view.page.browser_options import INSTALL_VISER, BrowserOptions
from setcmas_tools.view.replay.options import ReplayOptions


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        'runs',
        nargs='*',
        type=Path,
        metavar='RUN',
        help='a run that is over, or two: its folder, a bag, or a fleet.csv (default: the robots '
        'that run)',
    )
    BrowserOptions.add_to(parser, without=('operator',))
    ReplayOptions.add_to(parser)
    RvizFileOptions.add_to(parser)


def main(args: argparse.Namespace) -> int:
    """Show the robots until Ctrl-C; returns the exit status."""
    rviz = RvizFileOptions.of(args)
    if rviz.write_rviz and args.runs:
        raise SetcmasError('--write-rviz is for robots that run; name no run beside it')
    if rviz.write_rviz:
        robots = shown_robots(rviz.robots)
        write_config(rviz.write_rviz, robots, rviz.experiment)
        print(f'rviz2 -d {rviz.write_rviz} shows {robots_in_words(robots)}')
        return 0
    if surplus := rviz.changed():
        raise SetcmasError(
            f'{spelled(surplus[0])} is for the file of --write-rviz; the page shows all robots'
        )
    _check(ReplayOptions.of(args), len(args.runs))
    if not args.runs:
        require_ros()
    if not has_viser():
        raise SetcmasError(f'viser is needed and is missing: {INSTALL_VISER}')
    browser = BrowserOptions.of(args)
    if args.runs:
        from setcmas_tools.view.replay.main import show_runs  # it needs viser

        names = [path.resolve().name for path in args.runs]
        if len(set(names)) < len(names):
            names = [f'{path}, run {number}' for number, path in enumerate(args.runs, 1)]
        runs = [Run.load(path, warn) for path in args.runs]
        show_runs(dict(zip(names, runs, strict=True)), browser, ReplayOptions.of(args))
        return 0
    return run_in_foreground('view', browser_command(browser.arguments()))


def _check(replay: ReplayOptions, nb_runs: int) -> None:
    """See that options suit one run, two, or none, which is the robots that run."""
    if nb_runs > 2:
        raise SetcmasError(f'{nb_runs} runs are given; they must be one or two')
    if (surplus := replay.changed()) and not nb_runs:
        raise SetcmasError(f'{spelled(surplus[0])} is for a run that is over; name its folder')
    if replay.beside and nb_runs < 2:
        raise SetcmasError('--beside is for two runs; name another one')
