"""The tasks `tracking` and `waypoints`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np

from setcmas_ctrl.laws.references import number, points
from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.topics import robot_name
from setcmas_tools.measures.metric import Columns, Measured
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


@dataclass(frozen=True)
class TrackingMetrics(Measured):
    """RMS distances to the reference, by robot; the last two over all robots."""

    tracking_error_rms_m: dict[int, float]
    tracking_error_rms_second_half_m: dict[int, float]
    fleet_tracking_error_rms_m: float
    fleet_tracking_error_rms_second_half_m: float

    def columns(self) -> Columns:
        """Return the errors of each robot."""
        return {
            'RMS error\n(m)': ('.3f', self.tracking_error_rms_m),
            'RMS 2nd\nhalf (m)': ('.3f', self.tracking_error_rms_second_half_m),
        }

    def lines(self) -> list[str]:
        """Return the errors of the fleet."""
        return [
            f'tracking: RMS error {self.fleet_tracking_error_rms_m:.3f} m, '
            f'{self.fleet_tracking_error_rms_second_half_m:.3f} m over the second half'
        ]


def tracking_errors(grid: FleetGrid, radius: float, rate: float) -> dict[int, Floats]:
    """Return the distance of each robot to r(t) in m over time; arguments as for `tracking`."""
    reference = radius * np.array([np.cos(rate * grid.t), np.sin(rate * grid.t)])
    return {
        robot: np.hypot(x - reference[0], y - reference[1])
        for robot, x, y in zip(grid.robots, grid.x, grid.y, strict=True)
    }


def tracking(grid: FleetGrid, radius: float, rate: float) -> TrackingMetrics | None:
    """Return the errors to the reference r(t) = R (cos W t, sin W t), with R in m and W in rad/s.

    Source: Siciliano et al., Robotics, 2009, section 11.6.
    """
    errors = tracking_errors(grid, radius, rate)
    whole, late = rms_by_robot(grid.t, errors, 0.0), rms_by_robot(grid.t, errors, 0.5)
    if not late:
        return None
    return TrackingMetrics(whole, late, rms(list(whole.values())), rms(list(late.values())))


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
"""The task."""


REACHED_M = 0.10
"""Distance at which a waypoint counts as reached if the law does not say, as in nav_wp."""

_MOST_ROBOTS_WITH_TIMES = 8


@dataclass(frozen=True)
class WaypointMetrics(Measured):
    """Which waypoints were reached and when.

    Robots visit the list again and again: of W waypoints, the k-th time of a robot is that of
    waypoint number (k - 1) mod W + 1.
    """

    waypoints_m: list[list[float]]
    reached_within_m: float
    reached_at_s: dict[int, list[float]]

    @property
    def mean_reached(self) -> float:
        """How many waypoints a robot has reached, mean over the robots."""
        return float(np.mean([len(times) for times in self.reached_at_s.values()]))

    def columns(self) -> Columns:
        """Return how many waypoints each robot has reached."""
        counts = {robot: float(len(times)) for robot, times in self.reached_at_s.items()}
        return {'way-\npoints': ('.0f', counts)}

    def lines(self) -> list[str]:
        """Return when they were reached, of the first robots."""
        number = len(self.waypoints_m)
        lines = []
        for robot, times in islice(self.reached_at_s.items(), _MOST_ROBOTS_WITH_TIMES):
            visits = ', '.join(f'{k % number + 1} at {time:.1f}' for k, time in enumerate(times))
            lines.append(f'waypoints of {robot_name(robot)}: {visits + " s" if times else "none"}')
        return lines


def waypoints(table: FleetTable, references: Mapping[str, Any]) -> WaypointMetrics:
    """Return when each robot of a table reached the waypoints WPL, within REACHED, in m.

    As for the built-in laws: a waypoint is reached at the first row (t >= 0) that is nearer than
    REACHED; the search for the next one begins at the next row.
    """
    points, reached = np.array(references['WPL']), references['REACHED']
    times = {robot: _visits(table.of(robot), points, reached) for robot in table.robots}
    return WaypointMetrics(points.tolist(), reached, times)


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
"""The task."""
