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
from setcmas_tools.run.fleet_motion import FleetGrid
from setcmas_tools.run.run import Run

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
    """Return a run's distances from a reference at the shift in time where they are least.

    Two simulations start together and are not shifted. Otherwise the shift is the multiple of
    0.1 s up to `LARGEST_SHIFT_S` with the least RMS distance over all common robots and times,
    which are at least half of the shorter run.

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
        Times in s that both runs have, multiples of 0.1 s from t = 0 on, shape (K,), and the
        distances in m by robot, shape (K,), NaN where a run lacks the robot.
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
