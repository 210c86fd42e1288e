"""What a run is measured by for its task: formation, tracking, or waypoints."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from setcmas_tools.records.fleet_grid import FleetGrid
from setcmas_tools.records.fleet_table import FleetTable

Floats = NDArray[np.float64]

LEADER = 1
"""Number of the robot that leads a formation."""

MOST_ROBOTS_IN_PAIRS = 8
"""Of larger fleets the pairs are not listed one by one."""


@dataclass(frozen=True)
class FormationMetrics:
    """Position errors |p_i - p_1 - d_i| of followers, by robot; the last value over all."""

    position_error_final_m: dict[int, float]
    position_error_rms_last_quarter_m: dict[int, float]
    fleet_position_error_rms_last_quarter_m: float


@dataclass(frozen=True)
class DistanceMetrics:
    """Distance errors |p_i - p_j| - D over pairs of robots.

    `distance_errors_final_m` has a signed error for each pair, such as '1-2', of a small fleet.
    """

    distance_error_final_rms_m: float
    distance_error_final_largest_m: float
    distance_error_rms_last_quarter_m: float
    distance_errors_final_m: dict[str, float] | None


@dataclass(frozen=True)
class TrackingMetrics:
    """RMS distances to the reference, by robot; the last two over all robots."""

    tracking_error_rms_m: dict[int, float]
    tracking_error_rms_second_half_m: dict[int, float]
    fleet_tracking_error_rms_m: float
    fleet_tracking_error_rms_second_half_m: float


@dataclass(frozen=True)
class WaypointMetrics:
    """Which waypoints were reached and when.

    The list is gone through from its start, over and over: of W waypoints, the k-th time of a
    robot is that of waypoint number (k - 1) mod W + 1.
    """

    waypoints_m: list[list[float]]
    reached_within_m: float
    reached_at_s: dict[int, list[float]]


def formation(grid: FleetGrid, places: Floats) -> FormationMetrics | None:
    """Return the position errors of a formation by places.

    Source: Oh, Park and Ahn, A survey of multi-agent formation control, Automatica 53, 2015
    (displacement-based control).

    Args:
        grid: The fleet's motion.
        places: Places of robots 2, 3, ... beside the leader in m, shape (at least N - 1, 2).

    Returns:
        None without a leader or without a follower that is known at the same time as the leader.
    """
    if LEADER not in grid.robots:
        return None
    leader = grid.robots.index(LEADER)
    errors = {}
    for robot, x, y in zip(grid.robots, grid.x, grid.y, strict=True):
        if robot != LEADER:
            dx, dy = places[robot - LEADER - 1]
            errors[robot] = np.hypot(x - grid.x[leader] - dx, y - grid.y[leader] - dy)
    late = _rms_by_robot(grid.t, errors, 0.75)
    final = {robot: float(errors[robot][np.isfinite(errors[robot])][-1]) for robot in late}
    return FormationMetrics(final, late, _rms(list(late.values()))) if late else None


def tracking(grid: FleetGrid, radius: float, rate: float) -> TrackingMetrics | None:
    """Return the errors to the reference r(t) = R (cos W t, sin W t).

    Source: Siciliano et al., Robotics, 2009, section 11.6.

    Args:
        grid: The fleet's motion.
        radius: R in m.
        rate: W in rad/s.
    """
    reference = radius * np.array([np.cos(rate * grid.t), np.sin(rate * grid.t)])
    errors = {
        robot: np.hypot(x - reference[0], y - reference[1])
        for robot, x, y in zip(grid.robots, grid.x, grid.y, strict=True)
    }
    whole, late = _rms_by_robot(grid.t, errors, 0.0), _rms_by_robot(grid.t, errors, 0.5)
    if not late:
        return None
    return TrackingMetrics(whole, late, _rms(list(whole.values())), _rms(list(late.values())))


def distances(grid: FleetGrid, wanted: float) -> DistanceMetrics | None:
    """Return the errors of a formation by distances.

    All at the times at which all robots are known.
    Source: Krick, Broucke and Francis, International Journal of Control 82(3), 2009.

    Args:
        grid: The fleet's motion.
        wanted: D in m.

    Returns:
        None for one robot, or if all are not known at once in the last quarter.
    """
    known = np.isfinite(grid.x).all(axis=0) & _from_share(grid.t, 0.75)
    if len(grid.robots) < 2 or not known.any():
        return None
    x, y = grid.x[:, known], grid.y[:, known]
    squares, final = 0.0, []
    for i in range(len(x) - 1):
        errors = np.hypot(x[i + 1 :] - x[i], y[i + 1 :] - y[i]) - wanted
        squares += float(np.sum(errors**2))
        final += errors[:, -1].tolist()
    pairs = None
    if len(x) <= MOST_ROBOTS_IN_PAIRS:
        names = [f'{i}-{j}' for i, j in combinations(grid.robots, 2)]
        pairs = dict(zip(names, final, strict=True))
    rms = float(np.sqrt(squares / (len(final) * x.shape[1])))
    return DistanceMetrics(_rms(final), float(np.abs(final).max()), rms, pairs)


def waypoints(table: FleetTable, points: Floats, reached: float) -> WaypointMetrics:
    """Return when each robot of a table reached the waypoints, in the order of the list.

    As for the built-in laws: a waypoint is reached at the first row (t >= 0) that is nearer than
    `reached`; the next one is looked for from the next row on.

    Args:
        table: The motion of the robots that visit waypoints.
        points: The list, shape (W, 2), in m.
        reached: Distance in m.
    """
    times = {robot: _visits(table.of(robot), points, reached) for robot in table.robots}
    return WaypointMetrics(points.tolist(), reached, times)


def _visits(track: FleetTable, points: Floats, reached: float) -> list[float]:
    near = np.hypot(track.x[:, None] - points[:, 0], track.y[:, None] - points[:, 1]) < reached
    times: list[float] = []
    for t, near_points in zip(track.t.tolist(), near, strict=True):
        if t >= 0 and near_points[len(times) % len(points)]:
            times.append(t)
    return times


def _rms_by_robot(t: Floats, errors: dict[int, Floats], share: float) -> dict[int, float]:
    """Return the RMS errors from a share of the run on, of the robots that are known there."""
    late = _from_share(t, share)
    known = {robot: values[late & np.isfinite(values)] for robot, values in errors.items()}
    return {robot: _rms(values) for robot, values in known.items() if len(values)}


def _from_share(t: Floats, share: float) -> NDArray[np.bool_]:
    if not len(t):
        return np.zeros(0, dtype=bool)
    begin = t[0] + share * (t[-1] - t[0])
    return np.asarray(t >= begin - 1e-9)


def _rms(values: Floats | list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
