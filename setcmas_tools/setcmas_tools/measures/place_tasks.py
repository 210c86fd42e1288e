"""Tasks of robots for themselves: `tracking` and `waypoints`; and `coverage` of a box."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np

from setcmas_ctrl.laws.references import number, points
from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.palettes import plot_colour
from setcmas_simu.fleet.topics import robot_name
from setcmas_tools.measures.metric import Measured
from setcmas_tools.measures.task import (
    DOTTED,
    Errors,
    Task,
    hollow_marker,
    line_width,
    rms,
    rms_by_robot,
)
from setcmas_tools.run.fleet_motion import FleetGrid, FleetTable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

    from setcmas_tools.run.run import Run


_CORNERS = 181


def tracking_errors(grid: FleetGrid, radius: float, rate: float) -> dict[int, Floats]:
    """Return the distance of each robot to r(t) in m over time; arguments as for `tracking`."""
    reference = radius * np.array([np.cos(rate * grid.t), np.sin(rate * grid.t)])
    return {
        robot: np.hypot(x - reference[0], y - reference[1])
        for robot, x, y in zip(grid.robots, grid.x, grid.y, strict=True)
    }


def tracking(grid: FleetGrid, radius: float, rate: float) -> Measured | None:
    """Return the errors to the reference r(t) = R (cos W t, sin W t), with R in m and W in rad/s.

    They are RMS distances by robot, and over all robots. None without a known one at the end.
    Source: Siciliano et al., Robotics, 2009, section 11.6.
    """
    errors = tracking_errors(grid, radius, rate)
    whole, late = rms_by_robot(grid.t, errors, 0.0), rms_by_robot(grid.t, errors, 0.5)
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


class _Tracking(Task):
    def metrics(self, run: Run, references: Mapping[str, Any]) -> Mapping[str, Measured | None]:
        return {'tracking': tracking(run.counted_grid, references['R'], references['W'])}

    def errors(self, run: Run, references: Mapping[str, Any]) -> Errors:
        values = tracking_errors(run.counted_grid, references['R'], references['W'])
        return Errors('Tracking error', 'distance to the reference (m)', values)

    def draw(self, plot: str, axes: Axes, run: Run, references: Mapping[str, Any]) -> list[Line2D]:
        del run
        if plot not in ('trajectories', 'film'):
            return []
        angles = np.linspace(0.0, 2 * np.pi, _CORNERS)
        x, y = references['R'] * np.cos(angles), references['R'] * np.sin(angles)
        return axes.plot(x, y, label='reference', linewidth=1.5 * line_width(), **DOTTED)


TRACKING = _Tracking({'R': number, 'W': number})
"""The task `tracking`."""


REACHED_M = 0.10
"""Distance at which a waypoint counts as reached if the law does not say, as in nav_wp."""

_MOST_ROBOTS_WITH_TIMES = 8


def waypoints(table: FleetTable, references: Mapping[str, Any]) -> Measured:
    """Return when each robot of a table reached the waypoints WPL, within REACHED, in m.

    As for the built-in laws: a waypoint is reached at the first row (t >= 0) that is nearer than
    REACHED; the search for the next one begins at the next row. Robots visit the list again and
    again: of W waypoints, the k-th time of a robot is that of waypoint number (k - 1) mod W + 1.
    """
    points, reached = np.array(references['WPL']), references['REACHED']
    times = {robot: _visits(table.of(robot), points, reached) for robot in table.robots}
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


def draw_waypoints(axes: Axes, references: Mapping[str, Any]) -> list[Line2D]:
    """Draw waypoints in the order of the list; return entries for the legend."""
    points = np.array(references['WPL']).T
    handles = axes.plot(*points, label='waypoints', **hollow_marker('s', 1.1))
    axes.plot(*points, linewidth=line_width(), **DOTTED)
    return handles


class _Waypoints(Task):
    def metrics(self, run: Run, references: Mapping[str, Any]) -> Mapping[str, Measured | None]:
        return {'waypoints': waypoints(run.counted, references)}

    def draw(self, plot: str, axes: Axes, run: Run, references: Mapping[str, Any]) -> list[Line2D]:
        del run
        in_plane = plot in ('trajectories', 'film')
        return draw_waypoints(axes, references) if in_plane else []


WAYPOINTS = _Waypoints({'WPL': points, 'REACHED': number}, {'REACHED': REACHED_M})
"""The task `waypoints`."""


_MOST_TIMES, _MOST_M = 200, 1e6
_POINTS, _PIXELS = 60, 400  # along each side of the box


def box(value: Any) -> list[list[float]]:
    """Check that a reference is a box.

    Raises:
        ValueError: It is not; the message says what it must be.
    """
    corners = points(value)
    if len(corners) != 2 or not (np.diff(corners, axis=0) > 0).all() or np.max(corners) > _MOST_M:
        raise ValueError('it must be the corners [[left, bottom], [right, top]] of a box (m)')
    return corners


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


def _known(grid: FleetGrid) -> Floats:
    """Return the positions of all robots where they are known, shape (K, 2, N)."""
    places: Floats = np.stack([grid.x.T, grid.y.T], axis=1)
    return places[np.isfinite(places).all(axis=(1, 2))]


def coverage(grid: FleetGrid, corners: Floats) -> Measured | None:
    """Return the cost of a coverage in a box (m), from sampled points and times.

    The cost is the integral over the box of the squared distance to the nearest robot. The largest
    rise is above the lowest cost before, in percent of the cost at the start. None if the robots
    are never all known. Source: Cortes, Martinez, Karatas and Bullo, IEEE Transactions on Robotics
    and Automation 20(2), 2004.
    """
    places = _known(grid)
    if not len(places):
        return None
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


class _Coverage(Task):
    def metrics(self, run: Run, references: Mapping[str, Any]) -> Mapping[str, Measured | None]:
        return {'coverage': coverage(run.counted_grid, np.array(references['BOX']))}

    def draw(self, plot: str, axes: Axes, run: Run, references: Mapping[str, Any]) -> list[Line2D]:
        if plot not in ('trajectories', 'film'):
            return []
        (left, bottom), (right, top) = references['BOX']
        places = _known(run.counted_grid)
        if plot == 'trajectories' and len(places):
            _draw_cells(axes, run.counted_grid.robots, places[-1], np.array(references['BOX']))
        x, y = [left, right, right, left, left], [bottom, bottom, top, top, bottom]
        return axes.plot(x, y, label='box', color='0.15', linestyle=':', zorder=1.5)


def _draw_cells(axes: Axes, robots: list[int], places: Floats, corners: Floats) -> None:
    """Colour each point of a box like the robot that is nearest to it."""
    nearest = squared_distances(corners, places, _PIXELS).argmin(axis=0)
    colours = np.array([plot_colour(robot, len(robots)) for robot in robots])
    (left, right), (bottom, top) = corners.T.tolist()
    extent = (left, right, bottom, top)
    axes.imshow(colours[nearest], extent=extent, origin='lower', alpha=0.2, zorder=0.5)


COVERAGE = _Coverage({'BOX': box})
"""The task `coverage`."""
