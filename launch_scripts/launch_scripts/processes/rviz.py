"""RViz 2 for the robots."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from launch_scripts.terminal.terminal_output import warn
from setcmas_simu.simulator.rviz_config import rviz_config
from setcmas_tools.page.browser import has_display

_RVIZ = 'rviz2'
_ROBOTS_IF_UNKNOWN = 8

Companion = tuple[str, list[str]]
"""Name and command of an optional process."""


def shown_robots(robots: Sequence[int] | None, nb_robots: int | None = None) -> list[int]:
    """Return the robots in --robots or --nb-robots; by default the first 8."""
    return list(robots or range(1, (nb_robots or _ROBOTS_IF_UNKNOWN) + 1))


@contextmanager
def rviz_companion(
    wanted: bool, robots: list[int], experiment: bool = False, namespace: str = ''
) -> Iterator[list[Companion]]:
    """Yield RViz 2 if it is wanted; if it is not available, warn and suggest the page.

    The namespace of the fleet has no slash at its ends.
    """
    missing = why_no_rviz() if wanted else ''
    if missing:
        warn(f'--rviz: {missing}; to see the robots in a browser, run setcmas view')
    if not wanted or missing:
        yield []
        return
    with tempfile.TemporaryDirectory(prefix='setcmas_') as folder:
        path = Path(folder) / 'fleet.rviz'
        config = rviz_config(robots, experiment)
        if namespace:
            config = config.replace('Value: /', f'Value: /{namespace}/')
        path.write_text(config, encoding='utf-8')
        yield [('rviz', [_RVIZ, '-d', str(path)])]


def why_no_rviz() -> str:
    """Return why RViz 2 cannot start; '' if it can."""
    if shutil.which(_RVIZ) is None:
        return 'rviz2 is not installed, or its setup.bash is not sourced'
    if not has_display(os.environ, sys.platform):
        return 'rviz2 has no screen for its window'
    return ''
