"""Metrics of the tasks that a law declares; each is None for a run with another task."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations, islice
from typing import Any

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.topics import robot_name
from setcmas_tools.measures.agreement import convergence_rate, disagreement
from setcmas_tools.measures.metric import Measured
from setcmas_tools.measures.task_errors import (
    LEADER,
    errors_of,
    from_share,
    placed,
    rms,
    rms_by_robot,
    velocities,
    wanted_distances,
)
from setcmas_tools.run.fleet_motion import FleetGrid, FleetTable
from setcmas_tools.run.run import Run

_MOST_ROBOTS_IN_PAIRS = 8  # pairs of larger fleets are not listed
_MOST_ROBOTS_WITH_TIMES = 8


def _references(run: Run, *tasks: str) -> Mapping[str, Any] | None:
    """Return the references of a run with one of some tasks; None if it has another one."""
    if run.references is None or run.references.task not in tasks:
        return None
    return run.references.values


def tracking(run: Run) -> Measured | None:
    """Return the errors to the reference r(t) = R (cos W t, sin W t), with R in m and W in rad/s.

    They are RMS distances by robot, and over all robots. None without a known one at the end.
    Source: Siciliano et al., Robotics, 2009, section 11.6.
    """
    if _references(run, 'tracking') is None or not (errors := errors_of(run)):
        return None
    t = run.counted_grid.t
    whole, late = (rms_by_robot(t, errors.values, share) for share in (0.0, 0.5))
    if not late:
        return None
    of_fleet, of_fleet_late = rms([*whole.values()]), rms([*late.values()])
    values = {
        'tracking_error_rms_m': whole,
        'tracking_error_rms_second_half_m': late,
        'fleet_tracking_error_rms_m': of_fleet,
        'fleet_tracking_error_rms_second_half_m': of_fleet_late,
    }
    line = f'tracking: RMS error {of_fleet:.3f} m, {of_fleet_late:.3f} m over the second half'
    columns = {'RMS error\n(m)': ('.3f', whole), 'RMS 2nd\nhalf (m)': ('.3f', late)}
    return Measured(values, [line], columns)


def waypoints(run: Run) -> Measured | None:
    """Return when each robot, in a formation the leader, reached WPL, within REACHED, in m.

    As for the built-in laws: a waypoint is reached at the first row (t >= 0) that is nearer than
    REACHED; the search for the next one begins at the next row. Robots visit the list again and
    again: of W waypoints, the k-th time of a robot is that of waypoint number (k - 1) mod W + 1.
    """
    wanted = _references(run, 'waypoints', 'formation', 'distances')
    if wanted is None or 'WPL' not in wanted:
        return None
    table = run.counted
    robots = [LEADER] if _references(run, 'waypoints') is None else table.robots
    if not {*robots} <= {*table.robots}:
        return None
    points, reached = np.array(wanted['WPL']), wanted['REACHED']
    times = {robot: _visits(table.of(robot), points, reached) for robot in robots}
    values = {'waypoints_m': points.tolist(), 'reached_within_m': reached, 'reached_at_s': times}
    lines = []
    for robot, when in islice(times.items(), _MOST_ROBOTS_WITH_TIMES):
        visits = ', '.join(f'{k % len(points) + 1} at {t:.1f}' for k, t in enumerate(when))
        lines.append(f'waypoints of {robot_name(robot)}: {visits + " s" if when else "none"}')
    counts = {robot: float(len(when)) for robot, when in times.items()}
    return Measured(values, lines, {'way-\npoints': ('.0f', counts)})


def _visits(track: FleetTable, points: Floats, reached: float) -> list[float]:
    near = np.hypot(track.x[:, None] - points[:, 0], track.y[:, None] - points[:, 1]) < reached
    times: list[float] = []
    for t, near_points in zip(track.t.tolist(), near, strict=True):
        if t >= 0 and near_points[len(times) % len(points)]:
            times.append(t)
    return times


def formation(run: Run) -> Measured | None:
    """Return the errors of a formation by places: of each follower, and over all followers.

    None without a leader, or without a follower known at the same time. Source: Oh, Park and Ahn,
    A survey of multi-agent formation control, Automatica 53, 2015 (displacement-based control).
    """
    if _references(run, 'formation') is None or not (errors := errors_of(run)):
        return None
    late = rms_by_robot(run.counted_grid.t, errors.values, 0.75)
    if not late:
        return None
    known = {robot: values[np.isfinite(values)] for robot, values in errors.values.items()}
    final = {robot: float(known[robot][-1]) for robot in late}
    of_fleet = rms([*late.values()])
    values = {
        'position_error_final_m': final,
        'position_error_rms_last_quarter_m': late,
        'fleet_position_error_rms_last_quarter_m': of_fleet,
    }
    line = f'formation: RMS position error over the last 25 %: {of_fleet:.3f} m'
    columns = {'error at\nend (m)': ('.3f', final), 'RMS last\n25 % (m)': ('.3f', late)}
    return Measured(values, [line], columns)


def distances(run: Run) -> Measured | None:
    """Return the errors |p_i - p_j| - D of pairs of robots (m), at times with all robots known.

    Of small fleets each pair, such as '1-2', has its signed error at the end. Robots without a
    point in the wanted shape are left out. None for one robot, or if the robots are never all
    known in the last quarter. Source: Krick, Broucke and Francis, International Journal of Control
    82(3), 2009.
    """
    if (wanted := _references(run, 'distances')) is None:
        return None
    grid = placed(run.counted_grid, wanted['D'])
    known = np.isfinite(grid.x).all(axis=0) & from_share(grid.t, 0.75)
    if len(grid.robots) < 2 or not known.any():
        return None
    x, y = grid.x[:, known], grid.y[:, known]
    matrix, squares, final = wanted_distances(grid.robots, wanted['D']), 0.0, []
    for i in range(len(x) - 1):
        apart = np.hypot(x[i + 1 :] - x[i], y[i + 1 :] - y[i])
        errors = apart - matrix[i, i + 1 :, None]
        squares += float(np.sum(errors**2))
        final += errors[:, -1].tolist()
    pairs = None
    if len(x) <= _MOST_ROBOTS_IN_PAIRS:
        names = [f'{i}-{j}' for i, j in combinations(grid.robots, 2)]
        pairs = dict(zip(names, final, strict=True))
    late = float(np.sqrt(squares / (len(final) * x.shape[1])))
    end, largest = rms(final), float(np.abs(final).max())
    values = {
        'distance_error_final_rms_m': end,
        'distance_error_final_largest_m': largest,
        'distance_error_rms_last_quarter_m': late,
        'distance_errors_final_m': pairs,
    }
    line = (
        f'distances: RMS error {end:.3f} m at the end (largest {largest:.3f} m), {late:.3f} m '
        'over the last 25 %'
    )
    return Measured(values, [line])


_MOST_TIMES = 200
_POINTS = 60  # along each side of the box


def coverage(run: Run) -> Measured | None:
    """Return the cost of a coverage in a box (m), from sampled points and times.

    The cost is the integral over the box of the squared distance to the nearest robot. The largest
    rise is above the lowest cost before, in percent of the cost at the start. None if the robots
    are never all known. Source: Cortes, Martinez, Karatas and Bullo, IEEE Transactions on Robotics
    and Automation 20(2), 2004.
    """
    wanted = _references(run, 'coverage')
    if wanted is None or not len(places := known_places(run.counted_grid)):
        return None
    corners = np.array(wanted['BOX'])
    chosen = np.unique(np.linspace(0, len(places) - 1, _MOST_TIMES).astype(int))
    nearest = [squared_distances(corners, one, _POINTS).min(axis=0) for one in places[chosen]]
    costs = np.mean(nearest, axis=(1, 2)) * np.prod(np.diff(corners, axis=0))
    rise = float(np.max(costs - np.minimum.accumulate(costs)) / costs[0])
    start, end, percent = float(costs[0]), float(costs[-1]), round(100.0 * rise, 2)
    line = (
        f'coverage: cost {start:.4g} m^4 at the start, {end:.4g} m^4 at the end; it rose by at '
        f'most {percent:.2f} %'
    )
    values = {'cost_at_start_m4': start, 'cost_at_end_m4': end, 'largest_rise_percent': percent}
    return Measured(values, [line])


def known_places(grid: FleetGrid) -> Floats:
    """Return the positions of all robots where they are known, shape (K, 2, N)."""
    places: Floats = np.stack([grid.x.T, grid.y.T], axis=1)
    return places[np.isfinite(places).all(axis=(1, 2))]


def squared_distances(corners: Floats, places: Floats, count: int) -> Floats:
    """Return squared distances (m^2) of N places (2, N) from count x count points of a box.

    Returns:
        An array of shape (N, count, count), by place, y and x.
    """
    shares = (np.arange(count) + 0.5) / count
    x, y = corners[0, :, None] + np.diff(corners, axis=0).T * shares
    at_x, at_y = places[:, :, None, None]
    squares: Floats = (at_x - x) ** 2 + (at_y - y[:, None]) ** 2
    return squares


def honest(run: Run) -> Measured | None:
    """Return the agreement of all robots but rebels, at times when all their poses are known.

    The largest exit is the largest distance of a coordinate from the interval of their starts.
    """
    if (wanted := _references(run, 'resilience')) is None:
        return None
    grid = run.counted_grid
    places = np.stack([grid.x, grid.y])[:, ~np.isin(grid.robots, wanted['REBELS'])]
    places = places[..., np.isfinite(places[0]).all(axis=0)]
    if not places.size:
        return None
    starts = places[..., :1]
    above = places - starts.max(axis=1, keepdims=True)
    below = starts.min(axis=1, keepdims=True) - places
    exit_m = float(max(above.max(), below.max(), 0.0))
    apart = float(disagreement(*places)[-1])
    line = (
        f'honest robots: disagreement {apart:.3f} m at the end; '
        f'at most {exit_m:.3f} m outside the interval of their starts'
    )
    return Measured({'disagreement_at_end_m': apart, 'largest_exit_m': exit_m}, [line])


def alignment(run: Run) -> Measured | None:
    """Return the agreement of the robots' commanded velocities.

    The disagreement is the root mean square distance to the mean velocity, the spread of
    directions the angle of the smallest sector with those of all moving robots.
    """
    if _references(run, 'alignment') is None or (found := velocities(run)) is None:
        return None
    t, (vx, vy) = run.counted_grid.t, found
    values = disagreement(vx, vy)
    start, end = float(values[0]), float(values[-1])
    rate = convergence_rate(t, values, np.zeros(len(t), bool))
    x, y = float(vx[:, -1].mean()), float(vy[:, -1].mean())
    sector = spread(vx[:, -1], vy[:, -1])
    return Measured(
        {
            'disagreement_at_start_m_s': start,
            'disagreement_at_end_m_s': end,
            'convergence_rate_1_s': rate,
            'final_mean_vx_m_s': x,
            'final_mean_vy_m_s': y,
            'spread_of_directions_at_end_rad': sector,
        },
        [
            f'disagreement of velocities: {start:.3f} m/s at the start, {end:.3f} m/s at the end',
            f'convergence rate: {"unknown" if rate is None else f"{rate:.3g} 1/s"}',
            f'mean velocity at the end: ({x:.3f}, {y:.3f}) m/s; directions within '
            f'{sector:.3f} rad',
        ],
    )


def spread(vx: Floats, vy: Floats) -> float:
    """Return the angle in rad of the smallest sector with the directions of N velocities (N,)."""
    angles = np.sort(np.arctan2(vy, vx)[np.hypot(vx, vy) > 0.0])
    gaps = np.diff(angles, append=angles[:1] + 2 * np.pi)
    return float(2 * np.pi - gaps.max()) if len(gaps) else 0.0
