"""Best shift in time between two runs, and how far their robots are apart after it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import robot_name
from setcmas_tools.records.fleet_grid import FleetGrid
from setcmas_tools.run.run import Run

LARGEST_SHIFT_S = 10.0
"""Runs that do the same later than this are not brought together."""

_NOTHING_IN_COMMON = 'no robot is in both runs long enough to compare them'
_RATE_HZ = 10.0
_LEAST_COMMON = 0.5  # of the shorter run


@dataclass(frozen=True)
class Shifted:
    """A run beside a reference.

    Attributes:
        shift: How much later than the reference it does the same, in s.
        t: Times of the reference at which both are known, in s, shape (K,).
        distances: How far each robot is then from itself in the reference, in m, by its number.
    """

    shift: float
    t: Floats
    distances: Mapping[int, Floats]

    @property
    def rms(self) -> dict[int, float]:
        """The root mean square distance of each robot in m."""
        return {robot: _rms(d) for robot, d in self.distances.items() if np.isfinite(d).any()}

    def __str__(self) -> str:
        """Return the shift and the distances in words."""
        largest = {robot: np.nanmax(self.distances[robot]) for robot in self.rms}
        robot = max(largest, key=lambda one: largest[one])
        when = self.t[np.nanargmax(self.distances[robot])]
        later = f'{abs(self.shift):.1f} s {"later" if self.shift > 0 else "earlier"}'
        return (
            f'is nearest {later if self.shift else "at the same time"}: '
            f'{_rms(np.array([*self.rms.values()])):.3g} m apart (RMS), at most '
            f'{largest[robot]:.3g} m ({robot_name(robot)} at t = {when:.1f} s)'
        )


def best_shift(reference: Run, run: Run) -> Shifted:
    """Return a run beside a reference with the shift at which their robots are nearest.

    That is the multiple of 0.1 s up to `LARGEST_SHIFT_S` with the least RMS distance over all
    robots that are in both and over the times that are in both, half of the shorter run at least.

    Raises:
        SetcmasError: No robot is in both runs.
    """
    common = sorted({*reference.counted.robots} & {*run.counted.robots})
    if not common:
        raise SetcmasError(_NOTHING_IN_COMMON)
    ours, theirs = (_positions(one.counted_grid, common) for one in (reference, run))
    least = max(1.0, _LEAST_COMMON * min(len(ours), len(theirs)))
    most = round(LARGEST_SHIFT_S * _RATE_HZ)
    found = []
    for steps in sorted(range(-most, most + 1), key=abs):
        begin, end = max(0, -steps), min(len(ours), len(theirs) - steps)
        if end - begin < least:
            continue
        distances = np.linalg.norm(ours[begin:end] - theirs[begin + steps : end + steps], axis=2)
        if np.isfinite(distances).any():
            found.append((_rms(distances), steps, begin, distances))
    if not found:
        raise SetcmasError(_NOTHING_IN_COMMON)
    _, steps, begin, distances = min(found, key=lambda one: one[0])  # of equals the first
    t = (np.arange(len(distances)) + begin) / _RATE_HZ
    return Shifted(steps / _RATE_HZ, t, dict(zip(common, distances.T, strict=True)))


def _positions(grid: FleetGrid, robots: list[int]) -> Floats:
    """Return x and y of robots from t = 0 on, shape (K, N, 2)."""
    steps = np.round(grid.t * _RATE_HZ).astype(int)
    rows = [grid.robots.index(robot) for robot in robots]
    positions = np.full((int(steps.max(initial=-1)) + 1, len(robots), 2), np.nan)
    positions[steps] = np.stack([grid.x[rows], grid.y[rows]], axis=2).transpose(1, 0, 2)
    return positions


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.nanmean(np.square(values))))
