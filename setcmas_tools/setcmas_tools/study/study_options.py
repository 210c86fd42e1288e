"""Options of a study: variation, workers, plots."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import ClassVar

from setcmas_simu.option_groups import Form, Options, option
from setcmas_simu.option_kinds import DURATION, Kind, Whole


def cores() -> int:
    """Return the number of cores that this process may use."""
    affinity = getattr(os, 'sched_getaffinity', None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1


@dataclass(frozen=True, kw_only=True)
class SweepOptions(Options):
    """Varied values of a study, its metrics and its workers."""

    TITLE: ClassVar[str] = 'study'

    vary: tuple[str, ...] = option(
        Kind(metavar='NAME=VALUES'),
        'vary an option or a variable of the script: a list (loss=0,0.2,0.4), a range '
        'FIRST:LAST:COUNT (K=0.2:2:10) or log:FIRST:LAST:COUNT; repeat it to run all '
        'combinations',
        form=Form.REPEATED,
        default=(),
    )
    seeds: int = option(Whole(1), 'seeds per case, starting at --seed', default=1)
    metric: tuple[str, ...] = option(
        Kind(metavar='COLUMN'),
        'metric to plot, such as disagreement (see setcmas list); may be repeated',
        form=Form.REPEATED,
        default=(),
    )
    jobs: int = option(
        Whole(1), 'simultaneous runs', default=cores(), default_text='the number of cores'
    )
    timeout: float = option(DURATION, 'time limit of a run', default=60.0)
