"""The view beside the robots: RViz 2, a page in the browser, or none."""

from __future__ import annotations

import importlib.util
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from launch_scripts.processes.node_commands import BROWSER_VIEW, PAGE, node_command
from launch_scripts.processes.rviz import Companion, rviz_beside, why_no_rviz
from launch_scripts.terminal.terminal_output import warn
from setcmas_simu.errors import SetcmasError
from setcmas_simu.options.group import Options, flag, option
from setcmas_simu.options.kinds import OneOf
from setcmas_tools.view.page.browser_options import INSTALL_VISER, BrowserOptions

AUTO, BROWSER, NONE = 'auto', 'browser', 'none'


@dataclass(frozen=True)
class Choice:
    """Which views are started, and what is said about it (nothing if empty)."""

    rviz: bool = False
    browser: bool = False
    remark: str = ''


@dataclass(frozen=True, kw_only=True)
class ViewOptions(Options):
    """Which views there are beside the robots."""

    rviz: bool = flag('show the robots in RViz 2 as well')
    view: str = option(
        OneOf((AUTO, BROWSER, NONE)),
        'show the robots: on a page in the browser (also --view alone), not at all, or auto: '
        'RViz 2 if it is there, else the page, where a terminal tells of it',
        default=AUTO,
        alone=BROWSER,
    )


def choose_view(
    options: ViewOptions, attended: bool, no_rviz: str, viser_installed: bool
) -> Choice:
    """Return which views to start.

    Args:
        options: What --view and --rviz say.
        attended: Whether somebody reads the command's output.
        no_rviz: Why RViz 2 cannot be started; empty if it can.
        viser_installed: Whether the page can be served.

    Raises:
        SetcmasError: The page is wanted but cannot be served.
    """
    view, rviz = options.view, options.rviz
    if view == BROWSER:
        if not viser_installed:
            raise SetcmasError(f'--view needs viser, which is missing: {INSTALL_VISER}')
        return Choice(rviz=rviz, browser=True)
    if view == NONE or rviz or not attended:
        return Choice(rviz=rviz)
    if not no_rviz:
        return Choice(rviz=True)
    if viser_installed:
        return Choice(browser=True)
    return Choice(remark=f'no view of the robots: {INSTALL_VISER} gives one in the browser')


@contextmanager
def view_beside(
    options: ViewOptions, robots: list[int], experiment: bool = False
) -> Iterator[list[Companion]]:
    """Hand out the views of a fleet, as companions of the robots' process.

    Args:
        options: Which views are wanted.
        robots: Numbers of the robots.
        experiment: Whether they are real.

    Raises:
        SetcmasError: The page is wanted but cannot be served.
    """
    attended = sys.stdout.isatty() and 'CI' not in os.environ
    choice = choose_view(options, attended, why_no_rviz(), has_viser())
    if choice.remark:
        warn(choice.remark)
    with rviz_beside(choice.rviz, robots, experiment) as companions:
        page = browser_command(BrowserOptions(operator=experiment).arguments())
        yield companions + ([(PAGE, page)] if choice.browser else [])


def has_viser() -> bool:
    """Return whether the page can be served."""
    return importlib.util.find_spec('viser') is not None


def browser_command(arguments: Sequence[str] = ()) -> list[str]:
    """Return the command line that serves the page."""
    return node_command(BROWSER_VIEW, arguments)
