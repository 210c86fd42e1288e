"""RViz 2 for the robots, and its configuration."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from launch_scripts.terminal.terminal_output import warn
from setcmas_simu.errors import SetcmasError
from setcmas_simu.options.group import Options, flag, option
from setcmas_simu.options.kinds import PathTo, Robots
from setcmas_simu.simulator.rviz_config import rviz_config
from setcmas_tools.page.browser import has_display

_RVIZ = 'rviz2'
_ROBOTS_IF_UNKNOWN = 8

Companion = tuple[str, list[str]]
"""Name and command of an optional process."""


@dataclass(frozen=True, kw_only=True)
class RvizFileOptions(Options):
    """Options of an RViz 2 configuration file."""

    TITLE: ClassVar[str] = 'RViz 2'

    write_rviz: Path | None = option(
        PathTo(), 'write an RViz 2 configuration for a fleet, and show nothing', default=None
    )
    robots: tuple[int, ...] | None = option(
        Robots(),
        'robots in the configuration',
        default=None,
        default_text=f'1-{_ROBOTS_IF_UNKNOWN}',
    )
    experiment: bool = flag('for real robots: poses from motion capture, and the arena')


def shown_robots(robots: Sequence[int] | None, nb_robots: int | None = None) -> list[int]:
    """Return the robots in --robots or --nb-robots; by default the first 8."""
    return list(robots or range(1, (nb_robots or _ROBOTS_IF_UNKNOWN) + 1))


@contextmanager
def rviz_beside(
    wanted: bool, robots: list[int], experiment: bool = False
) -> Iterator[list[Companion]]:
    """Yield RViz 2 if it is wanted; if it is not available, warn and suggest the page."""
    missing = why_no_rviz() if wanted else ''
    if missing:
        warn(f'--rviz: {missing}; to see the robots in a browser, run setcmas view')
    if not wanted or missing:
        yield []
        return
    with tempfile.TemporaryDirectory(prefix='setcmas_') as folder:
        path = Path(folder) / 'fleet.rviz'
        write_config(path, robots, experiment)
        yield [('rviz', [_RVIZ, '-d', str(path)])]


def why_no_rviz() -> str:
    """Return why RViz 2 cannot start; '' if it can."""
    if shutil.which(_RVIZ) is None:
        return 'rviz2 is not installed, or its setup.bash is not sourced'
    if not has_display(os.environ, sys.platform):
        return 'rviz2 has no screen for its window'
    return ''


def write_config(path: Path, robots: list[int], experiment: bool = False) -> None:
    """Write an RViz 2 configuration for a fleet.

    Raises:
        SetcmasError: The file cannot be written.
    """
    try:
        path.write_text(rviz_config(robots, experiment), encoding='utf-8')
    except OSError as error:
        raise SetcmasError(f"'{path}' cannot be written: {error.strerror}") from error
