"""What any run is measured by: path, speed and saturation of robots, and their separation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from setcmas_tools.records.fleet_grid import LONGEST_GAP_S, FleetGrid
from setcmas_tools.records.fleet_table import FleetTable

Floats = NDArray[np.float64]

SATURATION_TOLERANCE = 1e-3
"""A robot is in saturation from (1 - this) vnom on."""


@dataclass(frozen=True)
class RobotMotion:
    """The motion of one robot from t = 0 on; None for what its rows do not tell."""

    path_length_m: float
    mean_speed_m_s: float | None
    largest_speed_m_s: float | None
    time_in_saturation_s: float
    end_x_m: float | None
    end_y_m: float | None


@dataclass(frozen=True)
class Separation:
    """How near and how far robots of a fleet are; None for what was never seen."""

    least_separation_m: float
    least_separation_time_s: float
    least_separation_robots: tuple[int, int]
    largest_distance_at_end_m: float | None


def robot_motion(track: FleetTable, vnom: float) -> RobotMotion:
    """Return the motion of a robot.

    The path length is the sum of the steps between poses (a polygon, so slightly short on bends),
    the mean speed that length over the time from the first to the last pose. The largest speed and
    the saturation are those of the odometry's speed |v|; each row tells it for the time since the
    row before, which counts if it is not longer than LONGEST_GAP_S.

    Args:
        track: The rows of one robot, at least one of them at t >= 0.
        vnom: Largest speed that was asked of robots in m/s.
    """
    counted = track.rows((track.t >= 0) & np.isfinite(track.x + track.y))
    length = float(np.hypot(np.diff(counted.x), np.diff(counted.y)).sum())
    duration = float(counted.t[-1] - counted.t[0]) if len(counted.t) else 0.0
    speeds = np.abs(track.v[(track.t >= 0) & np.isfinite(track.v)])
    return RobotMotion(
        path_length_m=length,
        mean_speed_m_s=length / duration if duration > 0 else None,
        largest_speed_m_s=float(speeds.max()) if len(speeds) else None,
        time_in_saturation_s=_time_in_saturation(track, vnom),
        end_x_m=float(counted.x[-1]) if len(counted.t) else None,
        end_y_m=float(counted.y[-1]) if len(counted.t) else None,
    )


def _time_in_saturation(track: FleetTable, vnom: float) -> float:
    durations = np.diff(np.maximum(track.t, 0.0))
    saturated = np.abs(track.v[1:]) >= vnom * (1 - SATURATION_TOLERANCE)
    known = np.diff(track.t) <= LONGEST_GAP_S
    return float(durations[saturated & known].sum())


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
