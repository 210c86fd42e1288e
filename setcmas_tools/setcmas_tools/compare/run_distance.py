"""Distances between two runs: at equal times, and after the best shift in time."""

from __future__ import annotations

import filecmp
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import robot_name
from setcmas_tools.measures.metrics import Metrics, as_dict, measure
from setcmas_tools.run.fleet_motion import FleetGrid
from setcmas_tools.run.run import Run

RATE_HZ = 10
"""Samples a second of the runs that are compared."""

LARGEST_SHIFT_S = 10.0
"""Largest shift in time between two runs."""

_NOTHING_IN_COMMON = 'no robot is in both runs long enough to compare them'
_LEAST_COMMON = 0.5  # of the shorter run
_LEAST_LIKENESS = 0.5


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
        """Return shift and distances as text."""
        largest = {robot: np.nanmax(self.distances[robot]) for robot in self.rms}
        robot = max(largest, key=lambda one: largest[one])
        when = self.t[np.nanargmax(self.distances[robot])]
        later = 'later' if self.shift > 0 else 'earlier'
        shift = f'is nearest {abs(self.shift):.1f} s {later}: ' if self.shift else 'is '
        return (
            f'{shift}{_rms(np.array([*self.rms.values()])):.3g} m apart (RMS), at most '
            f'{largest[robot]:.3g} m ({robot_name(robot)} at t = {when:.1f} s)'
        )


def is_experiment(run: Run) -> bool:
    """Return whether a run was an experiment, real or emulated: it has a safety record."""
    return run.tables.safety is not None


def best_shift(reference: Run, run: Run) -> Shifted:
    """Return the comparison of a run with a reference at the shift where robots are nearest.

    Two simulations start together: they are not shifted. Otherwise it is the multiple of 0.1 s up
    to `LARGEST_SHIFT_S` with the least RMS distance over all common robots and times; these are
    at least half of the shorter run.

    Raises:
        SetcmasError: No robot is in both runs.
    """
    common = sorted({*reference.counted.robots} & {*run.counted.robots})
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


def delay_of(reference: Floats, run: Floats) -> float | None:
    """Return the delay of the speeds of a run to those of a reference, in s.

    The delay maximises the mean correlation coefficient of speed and turn rate
    (cross-correlation: Ljung, System Identification, 1999, section 6.1).

    Args:
        reference: Rows of speeds and turn rates, `RATE_HZ` a second, shape (2, K).
        run: The same of the other run, shape (2, L).

    Returns:
        None if the speeds are not alike, or do not change.
    """
    found = {
        steps: _likeness(reference[:, mine], run[:, others])
        for steps, mine, others in shifts(reference.shape[1], run.shape[1])
    }
    best = max(found, key=lambda steps: found[steps], default=0)
    return best / RATE_HZ if found and found[best] >= _LEAST_LIKENESS else None


def shifts(ours: int, theirs: int) -> Iterator[tuple[int, slice, slice]]:
    """Yield shifts of two runs in samples, the smallest first, and the samples that then meet.

    Args:
        ours: Number of samples of the reference, `RATE_HZ` a second.
        theirs: That of the run, which is later by a positive shift.
    """
    least = max(1.0, _LEAST_COMMON * min(ours, theirs))
    most = round(LARGEST_SHIFT_S * RATE_HZ)
    for steps in sorted(range(-most, most + 1), key=abs):
        begin, end = max(0, -steps), min(ours, theirs - steps)
        if end - begin >= least:
            yield steps, slice(begin, end), slice(begin + steps, end + steps)


def _likeness(one: Floats, other: Floats) -> float:
    """Return the mean correlation coefficient of rows; rows that do not change do not count."""
    known = np.isfinite(one + other).all(axis=0)
    found = [
        float(np.corrcoef(row, column)[0, 1])
        for row, column in zip(one[:, known], other[:, known], strict=True)
        if len(row) > 2 and np.ptp(row) > 0.0 and np.ptp(column) > 0.0
    ]
    return float(np.mean(found)) if found else 0.0


def _positions(grid: FleetGrid, robots: list[int]) -> Floats:
    """Return x and y of robots from t = 0 on, shape (K, N, 2)."""
    steps = np.round(grid.t * RATE_HZ).astype(int)
    rows = [grid.robots.index(robot) for robot in robots]
    positions = np.full((int(steps.max(initial=-1)) + 1, len(robots), 2), np.nan)
    positions[steps] = np.stack([grid.x[rows], grid.y[rows]], axis=2).transpose(1, 0, 2)
    return positions


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.nanmean(np.square(values))))


_LEAST_CHANGE = 0.01
_LEAST_DIFFERENCE = 1e-3  # 1 mm, 1 mm/s, 1 ms
_MOST_CHANGES = 6


@dataclass(frozen=True)
class Apart:
    """The largest distance of a robot in one run to itself in another at the same time.

    Attributes:
        distance: The distance in m; NaN if no robot is in both runs at the same time.
        t: Its time in s.
        robot: Number of the robot.
    """

    distance: float
    t: float
    robot: int

    def __str__(self) -> str:
        """Return the distance, the robot and the time."""
        if not np.isfinite(self.distance):
            return 'no robot is in both runs at the same time'
        return (
            f'largest distance {self.distance:.3g} m ({robot_name(self.robot)} at '
            f't = {self.t:.1f} s)'
        )


def largest_distance(first: Run, second: Run) -> Apart:
    """Return the largest distance of two runs, at multiples of 0.1 s from the start."""
    largest = Apart(np.nan, np.nan, 0)
    t, distances = distances_between(first, second)
    for robot, values in distances.items():
        if np.isfinite(values).any() and not np.nanmax(values) <= largest.distance:
            step = int(np.nanargmax(values))
            largest = Apart(float(values[step]), float(t[step]), robot)
    return largest


def distances_between(first: Run, second: Run) -> tuple[Floats, dict[int, Floats]]:
    """Return the distance of each robot in two runs to itself at equal times.

    Returns:
        K multiples of 0.1 s from the first commands on that are in both; and distances in m by
        robot, shape (K,), NaN where it is not in both.
    """
    one, other = first.counted_grid, second.counted_grid
    steps, others = (np.round(grid.t * 10).astype(int) for grid in (one, other))
    common, i, j = np.intersect1d(steps, others, return_indices=True)
    distances = {}
    for robot in sorted({*one.robots} & {*other.robots}):
        k, m = one.robots.index(robot), other.robots.index(robot)
        distances[robot] = np.hypot(one.x[k][i] - other.x[m][j], one.y[k][i] - other.y[m][j])
    return common / 10, distances


def comparison_line(folder: Path, earlier: Path) -> str:
    """Return a line that compares the run in a folder with an earlier run.

    Raises:
        SetcmasError: A run cannot be read or measured.
    """
    theirs, ours = ({path.name for path in (f / 'csv').glob('*')} for f in (earlier, folder))
    same, _, _ = filecmp.cmpfiles(earlier / 'csv', folder / 'csv', ours | theirs, shallow=False)
    if theirs == ours == set(same):
        return f'identical to {earlier}: all {len(same)} files of its csv have the same bytes'
    run, other = Run.load(folder), Run.load(earlier)
    differing = changes(measure(other), measure(run))
    listed = '; '.join(differing[:_MOST_CHANGES]) or 'none'
    more = f' and {len(differing) - _MOST_CHANGES} more' if len(differing) > _MOST_CHANGES else ''
    return (
        f'compared with {earlier}: {largest_distance(run, other)}; metrics that differ by more '
        f'than {100 * _LEAST_CHANGE:g} % and {_LEAST_DIFFERENCE:g}: {listed}{more}'
    )


def changes(before: Metrics, after: Metrics) -> list[str]:
    """Return a text for each number that differs between metrics, the largest change first."""
    old, new = (flat(as_dict(metrics)) for metrics in (before, after))
    sizes = {}
    for name in [*old, *(new.keys() - old.keys())]:
        was, now = old.get(name), new.get(name)
        size = _change(was, now)
        if size > _LEAST_CHANGE:
            sizes[f'{name} {_text(was)} -> {_text(now)}'] = size
    return sorted(sizes, key=lambda text: -sizes[text])


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


def _change(was: Any, now: Any) -> float:
    """Return the change of a value, relative to the larger one; 1 if it is no number."""
    if isinstance(was, (int, float)) and isinstance(now, (int, float)):
        difference = abs(now - was)
        return difference / max(abs(now), abs(was)) if difference > _LEAST_DIFFERENCE else 0.0
    return float(was != now)


def _text(value: Any) -> str:
    return 'none' if value is None else f'{value:.4g}' if isinstance(value, float) else str(value)
