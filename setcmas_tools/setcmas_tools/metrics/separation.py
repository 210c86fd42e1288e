"""How near and how far apart the robots of a fleet were."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_tools.kinds.metric import Measured
from setcmas_tools.records.fleet_grid import FleetGrid
from setcmas_tools.run.run import Run


@dataclass(frozen=True)
class Separation(Measured):
    """How near and how far robots of a fleet are; None for what was never seen."""

    least_separation_m: float
    least_separation_time_s: float
    least_separation_robots: tuple[int, int]
    largest_distance_at_end_m: float | None

    def lines(self, task: str | None) -> list[str]:
        """Return the least and the largest distance."""
        del task
        first, second = self.least_separation_robots
        largest = self.largest_distance_at_end_m
        return [
            f'least separation: {self.least_separation_m:.2f} m at '
            f'{self.least_separation_time_s:.1f} s between robots {first} and {second}',
            'largest distance between two robots at the end: '
            f'{"-" if largest is None else format(largest, ".2f")} m',
        ]


def fleet_separation(run: Run) -> Separation | None:
    """Return how near and how far apart the robots of a run were; None for one robot."""
    return separation(run.counted_grid)


def separation(grid: FleetGrid) -> Separation | None:
    """Return the least distance of two robots, when it was, and the largest one at the end.

    Between two samples of the grid motion counts as straight, at constant speed. The end
    is the last sample at which all robots are known.

    Returns:
        None if no two robots are known at the same time.
    """
    steps = np.hypot(np.diff(grid.x), np.diff(grid.y))
    reach = 2 * np.nan_to_num(steps).max(axis=0, initial=0.0)
    least, when, pair = np.inf, np.nan, (0, 0)
    for i in range(len(grid.robots) - 1):  # a robot at a time: all pairs at once take gigabytes
        offsets = np.array([grid.x[i + 1 :] - grid.x[i], grid.y[i + 1 :] - grid.y[i]])
        distance, time, j = _least_distance(grid.t, offsets, reach)
        if distance < least:
            least, when, pair = distance, time, (grid.robots[i], grid.robots[i + 1 + j])
    if not np.isfinite(least):
        return None
    return Separation(least, when, pair, _largest_distance_at_end(grid))


def distances_of_pairs(grid: FleetGrid) -> tuple[Floats, Floats, Floats]:
    """Return the smallest, mean and largest distance of all pairs of robots in m over time.

    NaN where a robot is missing.
    """
    # A robot at a time: all pairs at once would take gigabytes for a long run of 50 robots.
    smallest = np.full(len(grid.t), np.nan)
    largest = smallest.copy()
    total, count = np.zeros(len(grid.t)), np.zeros(len(grid.t))
    for i in range(len(grid.robots) - 1):
        d = np.hypot(grid.x[i + 1 :] - grid.x[i], grid.y[i + 1 :] - grid.y[i])
        smallest = np.fmin(smallest, np.fmin.reduce(d))
        largest = np.fmax(largest, np.fmax.reduce(d))
        total += np.nansum(d, axis=0)
        count += np.isfinite(d).sum(axis=0)
    mean = np.divide(total, count, out=np.full(len(grid.t), np.nan), where=count > 0)
    for values in (smallest, mean, largest):
        values[~grid.complete] = np.nan
    return smallest, mean, largest


def _least_distance(t: Floats, offsets: Floats, reach: Floats) -> tuple[float, float, int]:
    """Return the least norm of moving points, its time, and which of the points has it.

    Args:
        t: Times, shape (K,).
        offsets: Rows x, y of M points at these times, shape (2, M, K); NaN where unknown.
        reach: How far points move at most from each time to the next, shape (K - 1,).
    """
    distances = np.sqrt(offsets[0] ** 2 + offsets[1] ** 2)
    distances[np.isnan(distances)] = np.inf
    point, sample = np.unravel_index(np.argmin(distances), distances.shape)
    least, when = float(distances[point, sample]), float(t[sample])
    if not np.isfinite(least):
        return least, when, int(point)
    points, samples = np.nonzero(distances[:, :-1] < least + reach)  # the others stay further off
    start = offsets[:, points, samples]
    step = offsets[:, points, samples + 1] - start
    squares = np.maximum(np.sum(step**2, axis=0), np.finfo(float).tiny)
    share = np.clip(-np.sum(start * step, axis=0) / squares, 0.0, 1.0)
    between = np.nan_to_num(np.hypot(*(start + share * step)), nan=np.inf)
    if len(between) and between.min() < least:
        best = int(np.argmin(between))
        k = samples[best]
        least, point = float(between[best]), points[best]
        when = float(t[k] + share[best] * (t[k + 1] - t[k]))
    return least, when, int(point)


def _largest_distance_at_end(grid: FleetGrid) -> float | None:
    known = np.flatnonzero(np.isfinite(grid.x).all(axis=0))
    if not len(known):
        return None
    x, y = grid.x[:, known[-1]], grid.y[:, known[-1]]
    return float(np.hypot(x[:, None] - x, y[:, None] - y).max())
