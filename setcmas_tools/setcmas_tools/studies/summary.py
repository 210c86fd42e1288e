"""Summary of a study: a table of medians."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tabulate import tabulate

from setcmas_tools.studies.groups import Group, median
from setcmas_tools.studies.study import Study
from setcmas_tools.studies.success import share_of

_MOST_GROUPS = 40
_FIRST = ('disagreement', 'settling_time', 'least_separation', 'communications')


def summary(study: Study) -> str:
    """Return the medians over seeds and draws of each case; of all runs if there are too many."""
    names = [name for name in study.names if name not in study.plan.cases.draws]
    groups = list(study.groups(*names))
    if len(groups) > _MOST_GROUPS:
        names, groups = [], list(study.groups())
    metrics = [name for name in _FIRST if name in study.metrics] or study.metrics[:4]
    heads = [*names, 'runs', 'broken', *(f'median\n{name}' for name in metrics)]
    heads += ['success'] if study.plan.info.success else []
    rows = [_summed_up(study, group, metrics) for group in groups]
    return tabulate(rows, heads, tablefmt='simple', floatfmt='.4g')


def _summed_up(study: Study, group: Group, metrics: Sequence[str]) -> list[Any]:
    rows = [row for row in group.rows if study.measured[row]]
    told: list[Any] = [*group.values.values(), len(group.rows), len(group.rows) - len(rows)]
    told += [median(study.numbers(name)[rows]) for name in metrics]
    if study.plan.info.success:
        share, low, high = share_of([study.successes()[row] for row in group.rows])
        told.append(f'{100 * share:.0f} % ({100 * low:.0f} to {100 * high:.0f})')
    return told
