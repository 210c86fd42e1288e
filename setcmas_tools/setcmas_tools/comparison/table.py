"""Table of the metrics of several runs, with the differences to the first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from tabulate import tabulate

from setcmas_tools.comparison.repeat import flat
from setcmas_tools.measures.metrics import Metrics, as_dict


def metrics_table(names: Sequence[str], metrics: Sequence[Metrics], form: str = 'simple') -> str:
    """Return a row for each number that some run has; numbers of each robot as their mean.

    Args:
        names: What the runs are called; the first is the reference.
        metrics: Theirs.
        form: A format of tabulate, 'simple' or 'html', which is escaped.
    """
    columns = [flat(_means(as_dict(one))) for one in metrics]
    rows = []
    for name in dict.fromkeys(key for column in columns for key in column):
        values = [column.get(name) for column in columns]
        if any(_is_number(value) for value in values):
            rows.append([name.replace('.(mean)', ' (mean)'), *_cells(values)])
    heads = ['', names[0], *(head for name in names[1:] for head in (name, 'difference'))]
    align = ['left', *['right'] * (len(heads) - 1)]
    return tabulate(rows, heads, tablefmt=form, disable_numparse=True, colalign=align)


def _cells(values: Sequence[Any]) -> list[str]:
    reference, *others = values
    cells = [_text(reference)]
    for value in others:
        known = _is_number(value) and _is_number(reference)
        difference = round(value - reference, 9) + 0.0 if known else None
        cells += [_text(value), f'{difference:+.4g}' if difference else '0' if known else '-']
    return cells


def _means(value: Any) -> Any:
    """Return metrics without lists, and with the mean over robots for numbers by robot."""
    if not isinstance(value, Mapping):
        return None if isinstance(value, list) else value
    if not value or not all(isinstance(key, int) for key in value):
        return {key: _means(inner) for key, inner in value.items()}
    inner = [flat(one) for one in value.values()]
    found = {}
    for key in dict.fromkeys(key for one in inner for key in one):
        known = [one[key] for one in inner if _is_number(one.get(key))]
        if known:
            found[f'{key} (mean)'.lstrip()] = float(np.mean(known))
    return found


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _text(value: Any) -> str:
    if value is None:
        return '-'
    return f'{value:.4g}' if _is_number(value) else str(value)
