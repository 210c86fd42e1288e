"""Differences between runs in parameters, scripts, versions and metrics."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from tabulate import tabulate

from setcmas_simu.fleet.fleet import format_robots
from setcmas_tools.compare.run_distance import flat, is_experiment
from setcmas_tools.measures.metrics import Metrics, as_dict
from setcmas_tools.run.run import Run, arena_of

_MOST_LINES = 60
_SAME_END_S = 1.0


def differences(reference: Run, run: Run) -> list[str]:
    """Return the differences of a run from a reference as lines: robots, end, options, files."""
    return [*_robots_and_end(reference, run), *_settings(reference, run)]


def _robots_and_end(reference: Run, run: Run) -> Iterator[str]:
    old, new = reference.robots, run.robots
    if old != new:
        both = sorted({*old} & {*new})
        alone = f'robot{"s" * (len(both) > 1)} {format_robots(both)} only'
        yield f'robots: {format_robots(old)} -> {format_robots(new)}'
        yield f'    distances are for {alone}; means are over all robots of each run'
    before, after = (float(one.table.t.max()) for one in (reference, run))
    if abs(after - before) > _SAME_END_S:
        yield f'end: {before:.1f} s -> {after:.1f} s; metrics cover each run to its own end'


def _settings(reference: Run, run: Run) -> Iterator[str]:
    both = {'the reference': reference, 'this run': run}
    unknown = [name for name, one in both.items() if not one.parameters]
    if unknown:
        yield f'options and versions of {" and ".join(unknown)} are not known'
        return
    yield from _changed('outcome', str(reference.outcome), str(run.outcome))
    yield from _options_changed(reference, run)
    if reference.info.origin and run.info.origin:
        yield from _changed('version of ', _origin(reference), _origin(run))
    yield from _inputs(reference, run)


def _options_changed(reference: Run, run: Run) -> Iterator[str]:
    old, new = flat(_options(reference)), flat(_options(run))
    kinds = ['experiment' if is_experiment(one) else 'simulation' for one in (reference, run)]
    if kinds[0] != kinds[1]:
        yield f'kind: {kinds[0]} -> {kinds[1]}; options that only one of them has are left out'
        both = [key for key in old if None not in (old[key], new.get(key))]
        old, new = ({key: values[key] for key in both} for values in (old, new))
    yield from _changed('', old, new)


def _options(run: Run) -> dict[str, Any]:
    arena = arena_of(run)
    borders = ', '.join(f'{border:g}' for border in arena) if arena else None
    return {**run.parameters, 'arena': borders}


def _origin(run: Run) -> Mapping[str, Any]:
    origin = run.info.origin
    return {'setcmas': origin.setcmas, **origin.versions} if origin else {}


def _changed(name: str, before: Any, after: Any) -> Iterator[str]:
    old, new = flat(before), flat(after)
    for key in dict.fromkeys([*old, *new]):
        if _text(old, key) != _text(new, key):
            yield f'{name}{key}: {_text(old, key)} -> {_text(new, key)}'


def _text(values: Mapping[str, Any], key: str) -> str:
    return str(values[key]) if values.get(key) is not None else 'none'


def _inputs(reference: Run, run: Run) -> Iterator[str]:
    """Yield the differences of scripts and other files, as `diff -u` shows them."""
    old, new = (_files(one) for one in (reference, run))
    for name in dict.fromkeys([*old, *new]):
        if name not in old or name not in new:
            yield f'{name}: only in {"the reference" if name in old else "this run"}'
        elif old[name] != new[name]:
            lines = list(difflib.unified_diff(old[name], new[name], n=1, lineterm=''))[2:]
            yield f'{name}:'
            yield from (f'    {line}' for line in lines[:_MOST_LINES])
            if len(lines) > _MOST_LINES:
                yield f'    and {len(lines) - _MOST_LINES} more lines'


def _files(run: Run) -> dict[str, list[str]]:
    return {
        f'{given.option} {file.relative_to(given.path.parent)}': content.decode(
            errors='replace'
        ).splitlines()
        for given in run.inputs
        for file, content in zip(given.files, given.contents, strict=True)
    }


def metrics_table(names: Sequence[str], metrics: Sequence[Metrics], form: str = 'simple') -> str:
    """Return a row for each number of any run; numbers of each robot as their mean.

    The first run is the reference; `form` is a format of `tabulate`.
    """
    columns = [flat(_means(as_dict(one))) for one in metrics]
    rows = []
    for name in dict.fromkeys(key for column in columns for key in column):
        values = [column.get(name) for column in columns]
        if any(_is_number(value) for value in values):
            rows.append([name.replace('.(mean)', ' (mean)'), *_cells(values)])
    heads = ['', names[0], *(head for name in names[1:] for head in (name, 'difference'))]
    table: str = tabulate(
        rows, heads, form, stralign='right', colalign=('left',), disable_numparse=True
    )
    return table


def _cells(values: Sequence[Any]) -> list[str]:
    reference, *others = values
    cells = [_number_text(reference)]
    for value in others:
        known = _is_number(value) and _is_number(reference)
        difference = round(value - reference, 9) + 0.0 if known else None
        cells += [
            _number_text(value),
            f'{difference:+.4g}' if difference else '0' if known else '-',
        ]
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


def _number_text(value: Any) -> str:
    if value is None:
        return '-'
    return f'{value:.4g}' if _is_number(value) else str(value)
