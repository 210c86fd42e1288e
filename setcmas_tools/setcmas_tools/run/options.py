"""Options of a whole run: how long it takes and where its results go."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from setcmas_simu.options.group import Options, flag, option
from setcmas_simu.options.kinds import DURATION, PathTo


@dataclass(frozen=True, kw_only=True)
class RunOptions(Options):
    """How long a run takes, and where its results go."""

    duration: float = option(
        DURATION,
        'length of the run, from the first command',
        default=40.0,
    )
    output: Path | None = option(
        PathTo(metavar='DIR'), 'folder of the results, to be created', default=None, short='-o'
    )
    plots: bool = flag('draw the plots', default=True)
    overwrite: bool = flag('replace an earlier run in that folder')
