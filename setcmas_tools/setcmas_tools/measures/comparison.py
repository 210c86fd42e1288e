"""Comparison of runs: distances of their robots, and differences in options and metrics."""

from __future__ import annotations

import difflib
import filecmp
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import robot_name
from setcmas_tools.measures.metrics import Metrics, as_dict
from setcmas_tools.run.fleet_motion import FleetGrid
from setcmas_tools.run.run import Run, arena_of

RATE_HZ = 10
"""Samples a second of the runs that are compared."""

LARGEST_SHIFT_S = 10.0
"""Largest shift in time between two runs."""

_NOTHING_IN_COMMON = 'no robot is in both runs long enough to compare them'
_LEAST_COMMON = 0.5  # of the shorter run


@dataclass(frozen=True)
class Shifted:
    """A run compared with a reference after a shift in time.

    Attributes:
        shift: Delay of the run to the reference in s.
        t: Times of the reference in both runs in s, shape (K,).
        distances: Distance of each robot to itself in the reference in m, by its number.
    """

    shift: float
    t: Floats
    distances: Mapping[int, Floats]

    @property
    def rms(self) -> dict[int, float]:
        """The root mean square distance of each robot in m."""
        return {robot: _rms(d) for robot, d in self.distances.items() if np.isfinite(d).any()}

    def __str__(self) -> str:
        largest = {robot: np.nanmax(self.distances[robot]) for robot in self.rms}
        robot = max(largest, key=lambda one: largest[one])
        when = self.t[np.nanargmax(self.distances[robot])]
        late = f'{"lags" if self.shift > 0 else "leads"} by {abs(self.shift):.1f} s'
        shift = f'{late}; with that shift, it is ' if self.shift else 'is '
        return (
            f'{shift}{_rms(np.array([*self.rms.values()])):.3g} m apart (RMS), at most '
            f'{largest[robot]:.3g} m ({robot_name(robot)} at t = {when:.1f} s)'
        )


def is_experiment(run: Run) -> bool:
    """Return whether a run was an experiment, real or emulated: it has a safety record."""
    return run.safety is not None


def best_shift(reference: Run, run: Run) -> Shifted:
    """Return a run's distances from a reference at the shift in time where they are least.

    Two simulations start together and are not shifted. Otherwise the shift is the multiple of
    0.1 s up to `LARGEST_SHIFT_S` with the least RMS distance over all common robots and times,
    which are at least half of the shorter run.

    Raises:
        SetcmasError: No robot is in both runs.
    """
    common = _common_robots(reference, run)
    if not common:
        raise SetcmasError(_NOTHING_IN_COMMON)
    ours, theirs = (_positions(one.counted_grid, common) for one in (reference, run))
    together = all(one.parameters and not is_experiment(one) for one in (reference, run))
    found = []
    for steps, mine, others in islice(shifts(len(ours), len(theirs)), 1 if together else None):
        distances = np.linalg.norm(ours[mine] - theirs[others], axis=2)
        if np.isfinite(distances).any():
            found.append((_rms(distances), steps, mine.start, distances))
    if not found:
        raise SetcmasError(_NOTHING_IN_COMMON)
    _, steps, begin, distances = min(found, key=lambda one: one[0])  # of equals the first
    t = (np.arange(len(distances)) + begin) / RATE_HZ
    return Shifted(steps / RATE_HZ, t, dict(zip(common, distances.T, strict=True)))


def shifts(ours: int, theirs: int) -> Iterator[tuple[int, slice, slice]]:
    """Yield shifts of two runs in samples, the smallest first, and the samples that overlap.

    Args:
        ours: Number of samples of the reference, `RATE_HZ` a second.
        theirs: Number of samples of the run; it is later if the shift is positive.
    """
    least = max(1.0, _LEAST_COMMON * min(ours, theirs))
    most = round(LARGEST_SHIFT_S * RATE_HZ)
    for steps in sorted(range(-most, most + 1), key=abs):
        begin, end = max(0, -steps), min(ours, theirs - steps)
        if end - begin >= least:
            yield steps, slice(begin, end), slice(begin + steps, end + steps)


def _positions(grid: FleetGrid, robots: list[int]) -> Floats:
    """Return x and y of robots from t = 0 on, shape (K, N, 2)."""
    steps = np.round(grid.t * RATE_HZ).astype(int)
    rows = [grid.robots.index(robot) for robot in robots]
    positions = np.full((int(steps.max(initial=-1)) + 1, len(robots), 2), np.nan)
    positions[steps] = np.stack([grid.x[rows], grid.y[rows]], axis=2).transpose(1, 0, 2)
    return positions


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.nanmean(np.square(values))))


def distances_between(first: Run, second: Run) -> tuple[Floats, dict[int, Floats]]:
    """Return the distance of each robot between two runs at equal times.

    Returns:
        Times in s from 0 to the end of the shorter run, shape (K,), and the distances in m by
        robot, shape (K,), NaN where a run lacks the robot.
    """
    common = _common_robots(first, second)
    ours, theirs = (_positions(one.counted_grid, common) for one in (first, second))
    length = min(len(ours), len(theirs))
    distances = np.linalg.norm(ours[:length] - theirs[:length], axis=2)
    return np.arange(length) / RATE_HZ, dict(zip(common, distances.T, strict=True))


def _common_robots(first: Run, second: Run) -> list[int]:
    return sorted({*first.counted.robots} & {*second.counted.robots})


def comparison_line(folder: Path, earlier: Path) -> str:
    """Return a line that compares the run in a folder with an earlier run.

    Raises:
        SetcmasError: A run cannot be read, or no robot is in both.
    """
    theirs, ours = ({path.name for path in (f / 'csv').glob('*')} for f in (earlier, folder))
    same, _, _ = filecmp.cmpfiles(earlier / 'csv', folder / 'csv', ours | theirs, shallow=False)
    if theirs == ours == set(same):
        return f'identical to {earlier}: all {len(same)} files of its csv have the same bytes'
    distance = best_shift(Run.load(earlier), Run.load(folder))
    return f'compared with {earlier}: this run {distance}; setcmas compare shows the metrics'


def flat(value: Any, name: str = '') -> dict[str, Any]:
    """Return nested values by names with dots between."""
    if isinstance(value, Mapping):
        parts: Iterable[tuple[Any, Any]] = value.items()
    elif isinstance(value, list):
        parts = enumerate(value, start=1)
    else:
        return {name: value}
    found: dict[str, Any] = {}
    for part, inner in parts:
        found |= flat(inner, f'{name}.{part}' if name else str(part))
    return found


def differences(reference: Run, run: Run) -> Iterator[str]:
    """Yield the differences of a run from a reference as lines: outcome, options, files."""
    runs = {'the reference': reference, 'this run': run}
    unknown = [name for name, one in runs.items() if not one.parameters]
    if unknown:
        yield f'options and versions of {" and ".join(unknown)} are not known'
        return
    old, new = _facts(reference), _facts(run)
    if old['kind'] != new['kind']:
        yield f'kind: {old["kind"]} -> {new["kind"]}; what only one of them has is left out'
        both = [key for key in old if key in new]
        old, new = ({key: one[key] for key in both} for one in (old, new))
    for key in dict.fromkeys([*old, *new]):
        if key != 'kind' and old.get(key) != new.get(key):
            yield f'{key}: {old.get(key, "none")} -> {new.get(key, "none")}'
    yield from _inputs(reference, run)


def _facts(run: Run) -> dict[str, str]:
    """Return outcome, options and versions of a run as texts by name; none that are None."""
    arena, origin = arena_of(run), run.info.origin
    facts = {
        'kind': 'experiment' if is_experiment(run) else 'simulation',
        'outcome': run.outcome,
        **run.parameters,
        'arena': ', '.join(f'{border:g}' for border in arena) if arena else None,
        'version of setcmas': origin.setcmas if origin else None,
        **{f'version of {name}': one for name, one in (origin.versions if origin else {}).items()},
    }
    return {name: str(one) for name, one in flat(facts).items() if one is not None}


def _inputs(reference: Run, run: Run) -> Iterator[str]:
    """Yield the differences of scripts and other files, as `diff -u` shows them."""
    old, new = (_files(one) for one in (reference, run))
    for name in dict.fromkeys([*old, *new]):
        if name not in old or name not in new:
            yield f'{name}: only in {"the reference" if name in old else "this run"}'
        elif old[name] != new[name]:
            lines = list(difflib.unified_diff(old[name], new[name], n=1, lineterm=''))[2:]
            yield f'{name}:'
            yield from (f'    {line}' for line in lines)


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
    from tabulate import tabulate  # here: `check` does not need it

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
        changed = f'{difference:+.4g}' if difference else '0' if known else '-'
        cells += [_number_text(value), changed]
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
