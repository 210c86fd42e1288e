"""Show running robots, or a finished run, on a page in the browser until Ctrl-C.

The page shows poses, trails, drawings of control scripts and communication, with a time bar and
charts. Its buttons pause, start and reset simulated robots, and pause and stop real ones. Select a
robot of a finished run to see the velocity that its law returned.

Examples:
  setcmas view
  setcmas view out                               a finished run: its folder, a bag, or a fleet.csv
  setcmas view --host 0.0.0.0 --read-only        for others on the network, without buttons
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from launch_scripts.environment import require_ros
from launch_scripts.processes import (
    BROWSER_VIEW,
    PAGE,
    add_ros_arguments,
    namespace_rule,
    node_command,
)
from launch_scripts.supervisor import run_node
from launch_scripts.terminal import warn
from setcmas_simu.fleet.rviz_config import rviz_config
from setcmas_simu.option_groups import Options, option
from setcmas_simu.option_kinds import OneOf
from setcmas_tools.page.browser import BrowserOptions, has_display


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    run = 'a finished run: folder, bag or fleet.csv (default: the running robots)'
    parser.add_argument('run', nargs='?', type=Path, metavar='RUN', help=run)
    BrowserOptions.add_to(parser)
    add_ros_arguments(parser)


def main(args: argparse.Namespace) -> int:
    """Show the robots until Ctrl-C; return the exit status."""
    browser = BrowserOptions.of(args)
    if args.run is None:
        require_ros()
        return run_node(args, BROWSER_VIEW, browser.arguments())
    from setcmas_tools.page.report_file import report_page, run_name
    from setcmas_tools.page.server import show_page  # these need matplotlib and websockets
    from setcmas_tools.run.run import Run

    show_page(report_page(Run.load(args.run, warn), run_name(args.run), warn), browser)
    return 0


_RVIZ = 'rviz2'


def why_no_rviz() -> str:
    """Return why RViz 2 cannot start; '' if it can."""
    if shutil.which(_RVIZ) is None:
        return 'rviz2 is not installed, or its setup.bash is not sourced'
    if not has_display(os.environ, sys.platform):
        return 'rviz2 has no screen for its window'
    return ''


AUTO, BROWSER, RVIZ, NONE = 'auto', 'browser', 'rviz', 'none'


@dataclass(frozen=True, kw_only=True)
class ViewOptions(Options):
    """Where the robots are shown."""

    view: str = option(
        OneOf((AUTO, BROWSER, RVIZ, NONE)),
        'browser (also --view alone) serves a page with the robots, rviz starts RViz 2, none '
        'shows nothing, and auto starts RViz 2, or serves the page if RViz 2 cannot start; '
        'without a terminal, auto shows nothing',
        default=AUTO,
        alone=BROWSER,
    )


@contextmanager
def fleet_views(
    options: ViewOptions,
    robots: list[int],
    experiment: bool = False,
    ros_arguments: Sequence[str] = (),
) -> Iterator[list[tuple[str, list[str]]]]:
    """Yield names and commands of processes that show a fleet, in its namespace.

    If RViz 2 is wanted but not available, warn and suggest the page.
    """
    view, no_rviz = options.view, why_no_rviz()
    if view == AUTO:
        is_attended = sys.stdout.isatty() and 'CI' not in os.environ
        view = NONE if not is_attended else BROWSER if no_rviz else RVIZ
    rule = namespace_rule(ros_arguments)
    if view == RVIZ and no_rviz:
        warn(f'--view rviz: {no_rviz}; --view shows the robots in a browser')
    if view != RVIZ or no_rviz:
        yield [(PAGE, node_command(BROWSER_VIEW, rule))] if view == BROWSER else []
        return
    with tempfile.TemporaryDirectory(prefix='setcmas_') as folder:
        path, config = Path(folder) / 'fleet.rviz', rviz_config(robots, experiment)
        if namespace := '/'.join(rule[-1:]).removeprefix('__ns:=').strip('/'):
            config = config.replace('Value: /', f'Value: /{namespace}/')
        path.write_text(config, encoding='utf-8')
        yield [(RVIZ, [_RVIZ, '-d', str(path)])]
