"""Options of a study: variation, workers, plots."""

from __future__ import annotations

import os
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from setcmas_simu.errors import SetcmasError
from setcmas_simu.options.group import Options, flag, option
from setcmas_simu.options.kinds import DURATION, Kind, PathTo, Whole
from setcmas_simu.options.option import Form


def _names(parsed_args: Any, **_: Any) -> Iterable[str]:
    from setcmas_tools.study.variation import OPTIONS, names_of_scripts

    with suppress(SetcmasError):
        return [
            f'{name}=' for name in (*OPTIONS, *names_of_scripts(getattr(parsed_args, 'algo', '')))
        ]
    return [f'{name}=' for name in OPTIONS]


def _columns(**_: Any) -> Iterable[str]:
    from setcmas_tools.study.study_columns import COLUMNS  # completion alone needs them here

    return list(COLUMNS)


def cores() -> int:
    """Return the number of cores that this process may use."""
    affinity = getattr(os, 'sched_getaffinity', None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1


@dataclass(frozen=True, kw_only=True)
class SweepOptions(Options):
    """What is varied, and how the runs are made."""

    TITLE: ClassVar[str] = 'study'

    vary: tuple[str, ...] = option(
        Kind(metavar='NAME=VALUES'),
        'vary an option or a name of the script: a list (loss=0,0.2,0.4), a range '
        'FIRST:LAST:COUNT (K=0.2:2:10) or log:FIRST:LAST:COUNT, or a draw for each run, '
        'uniform:LOW:HIGH, loguniform:LOW:HIGH, normal:MEAN:DEVIATION; may be repeated: all '
        'combinations are run',
        form=Form.REPEATED,
        default=(),
        complete=_names,
    )
    cases: Path | None = option(
        PathTo(metavar='FILE.csv'),
        'vary names together: a line of names, then a line for each case',
        default=None,
    )
    seeds: int = option(Whole(1), 'run each case with so many seeds, from --seed on', default=1)
    success: str | None = option(
        Kind(metavar='EXPRESSION'),
        "what makes a run a success, such as 'disagreement<0.1 and least_separation>0.2'",
        default=None,
    )
    metric: tuple[str, ...] = option(
        Kind(metavar='COLUMN'),
        'what is drawn, such as disagreement (see setcmas list); may be repeated',
        form=Form.REPEATED,
        default=(),
        complete=_columns,
    )
    jobs: int = option(
        Whole(1), 'runs at a time', default=cores(), default_text='the number of cores'
    )
    cluster: str | None = option(
        Kind(metavar='ADDRESS'),
        'let the workers of this Dask scheduler make the runs, such as tcp://10.0.0.1:8786',
        default=None,
    )
    timeout: float = option(DURATION, 'end a run that takes longer', default=60.0)
    dry_run: bool = flag('print the number of runs, and run none')
