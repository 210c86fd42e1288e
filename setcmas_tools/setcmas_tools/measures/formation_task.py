"""The tasks `formation` and `distances`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from setcmas_ctrl.laws.references import number, points
from setcmas_simu.arrays import Floats
from setcmas_tools.measures.metric import Measured
from setcmas_tools.measures.place_tasks import REACHED_M, draw_waypoints, waypoints
from setcmas_tools.measures.task import Errors, Task, from_share, hollow_marker, rms, rms_by_robot
from setcmas_tools.run.fleet_motion import FleetGrid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

    from setcmas_tools.run.run import Run


LEADER = 1
"""Number of the leader of a formation."""


def place_errors(grid: FleetGrid, places: Floats) -> dict[int, Floats]:
    """Return the error of each follower in m over time; arguments as for `formation`."""
    if LEADER not in grid.robots:
        return {}
    leader = grid.robots.index(LEADER)
    errors = {}
    for robot, x, y in zip(grid.robots, grid.x, grid.y, strict=True):
        if LEADER < robot <= LEADER + len(places):
            dx, dy = places[robot - LEADER - 1]
            errors[robot] = np.hypot(x - grid.x[leader] - dx, y - grid.y[leader] - dy)
    return errors


def formation(grid: FleetGrid, places: Floats) -> Measured | None:
    """Return the errors of a formation by places: those of robots 2, 3, ... in m, shape (M, 2).

    Errors |p_i - p_1 - d_i| are those of each follower, and over all followers.
    Places are relative to the leader; further followers have none. None without a leader, or
    without a follower known at the same time. Source: Oh, Park and Ahn, A survey of multi-agent
    formation control, Automatica 53, 2015 (displacement-based control).
    """
    errors = place_errors(grid, places)
    late = rms_by_robot(grid.t, errors, 0.75)
    final = {robot: float(errors[robot][np.isfinite(errors[robot])][-1]) for robot in late}
    if not late:
        return None
    of_fleet = rms([*late.values()])
    values = {
        'position_error_final_m': final,
        'position_error_rms_last_quarter_m': late,
        'fleet_position_error_rms_last_quarter_m': of_fleet,
    }
    line = f'formation: RMS position error over the last 25 %: {of_fleet:.3f} m'
    columns = {'error at\nend (m)': ('.3f', final), 'RMS last\n25 % (m)': ('.3f', late)}
    return Measured(values, [line], columns)


class _LedTask(Task):
    """A formation whose leader may visit waypoints."""

    def metrics(self, run: Run, references: Mapping[str, Any]) -> Mapping[str, Measured | None]:
        if 'WPL' not in references or LEADER not in run.counted.robots:
            return {}
        return {'waypoints': waypoints(run.counted.of(LEADER), references)}

    def draw(self, plot: str, axes: Axes, run: Run, references: Mapping[str, Any]) -> list[Line2D]:
        del run
        in_plane = plot in ('trajectories', 'film') and 'WPL' in references
        return draw_waypoints(axes, references) if in_plane else []


class _Formation(_LedTask):
    def metrics(self, run: Run, references: Mapping[str, Any]) -> Mapping[str, Measured | None]:
        found = formation(run.counted_grid, np.array(references['PLACES']))
        return {'formation': found, **super().metrics(run, references)}

    def errors(self, run: Run, references: Mapping[str, Any]) -> Errors | None:
        values = place_errors(run.counted_grid, np.array(references['PLACES']))
        return Errors('Formation error', 'distance to the place (m)', values) if values else None

    def draw(self, plot: str, axes: Axes, run: Run, references: Mapping[str, Any]) -> list[Line2D]:
        handles = super().draw(plot, axes, run, references)
        if plot == 'trajectories':  # in a film they would have to move along with the leader
            handles += _draw_places(axes, run, np.array(references['PLACES']))
        return handles


def _draw_places(axes: Axes, run: Run, places: Floats) -> list[Line2D]:
    """Draw the followers' places relative to the leader's end position, in m."""
    leader = run.table.of(LEADER)
    leader = leader.rows(np.isfinite(leader.x + leader.y))
    if not len(leader.t) or max(run.robots) == LEADER:
        return []
    at_end = np.array([leader.x[-1], leader.y[-1]]) + places[: max(run.robots) - 1]
    return axes.plot(*at_end.T, label='places at the end', **hollow_marker('o', 2.8))


FORMATION = _Formation(
    {'PLACES': points, 'WPL': points, 'REACHED': number}, {'WPL': None, 'REACHED': REACHED_M}
)
"""The task."""


MOST_ROBOTS_IN_PAIRS = 8
"""For larger fleets, pairs are not listed individually."""

_MOST_REFERENCES = 4  # of several distances in a plot


Wanted = float | list[list[float]]
"""The distance between any two robots in m, or the shape: a point for each of robots 1, 2, ..."""


def distance_or_shape(value: Any) -> Wanted:
    """Check that a reference is a distance, or the points of a shape.

    Raises:
        ValueError: It is neither; the message says what it must be.
    """
    return points(value) if isinstance(value, (list, tuple, np.ndarray)) else number(value)


def _placed(grid: FleetGrid, wanted: Wanted) -> FleetGrid:
    """Return a grid without the robots that have no point in the wanted shape."""
    most = len(wanted) if isinstance(wanted, list) else math.inf
    kept = np.array(grid.robots) <= most
    robots = [robot for robot in grid.robots if robot <= most]
    return FleetGrid(grid.t, robots, grid.x[kept], grid.y[kept], grid.theta[kept])


def _matrix(robots: list[int], wanted: Wanted) -> Floats:
    """Return the wanted distances of robots in m, shape (N, N)."""
    if isinstance(wanted, list):
        x, y = np.reshape(wanted, (-1, 2))[np.array(robots, dtype=int) - 1].T
        return np.asarray(np.hypot(x - x[:, None], y - y[:, None]))
    return np.full((len(robots), len(robots)), wanted)


def distances(grid: FleetGrid, wanted: Wanted) -> Measured | None:
    """Return the errors |p_i - p_j| - D of pairs of robots (m), at times with all robots known.

    Of small fleets each pair, such as '1-2', has its signed error at the end. Robots without a
    point in the wanted shape are left out. None for one robot, or if the robots are never all
    known in the last quarter. Source: Krick, Broucke and Francis, International Journal of Control
    82(3), 2009.
    """
    grid = _placed(grid, wanted)
    known = np.isfinite(grid.x).all(axis=0) & from_share(grid.t, 0.75)
    if len(grid.robots) < 2 or not known.any():
        return None
    x, y = grid.x[:, known], grid.y[:, known]
    matrix, squares, final = _matrix(grid.robots, wanted), 0.0, []
    for i in range(len(x) - 1):
        apart = np.hypot(x[i + 1 :] - x[i], y[i + 1 :] - y[i])
        errors = apart - matrix[i, i + 1 :, None]
        squares += float(np.sum(errors**2))
        final += errors[:, -1].tolist()
    pairs = None
    if len(x) <= MOST_ROBOTS_IN_PAIRS:
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


def distance_errors(grid: FleetGrid, wanted: Wanted) -> dict[int, Floats]:
    """Return the RMS error of each robot's distances to the others in m over time."""
    grid = _placed(grid, wanted)
    matrix, errors = _matrix(grid.robots, wanted), {}
    for i, robot in enumerate(grid.robots):
        gaps = np.hypot(grid.x - grid.x[i], grid.y - grid.y[i]) - matrix[i, :, None]
        errors[robot] = np.sqrt(np.mean(np.delete(gaps, i, axis=0) ** 2, axis=0))
    return errors


class _Distances(_LedTask):
    def metrics(self, run: Run, references: Mapping[str, Any]) -> Mapping[str, Measured | None]:
        found = distances(run.counted_grid, references['D'])
        return {'distances': found, **super().metrics(run, references)}

    def errors(self, run: Run, references: Mapping[str, Any]) -> Errors | None:
        values = distance_errors(run.counted_grid, references['D'])
        if len(values) < 2:
            return None
        return Errors('Distance error', 'RMS error of the distances (m)', values)

    def draw(self, plot: str, axes: Axes, run: Run, references: Mapping[str, Any]) -> list[Line2D]:
        if plot != 'distances':
            return super().draw(plot, axes, run, references)
        grid = _placed(run.counted_grid, references['D'])
        wanted = _matrix(grid.robots, references['D'])
        values = np.unique(wanted[np.triu_indices(len(wanted), 1)].round(3)).tolist()
        if not 0 < len(values) <= _MOST_REFERENCES:
            return []
        label = f'reference, {", ".join(format(value, "g") for value in values)} m'
        look: dict[str, Any] = {'color': '0.15', 'linestyle': ':', 'zorder': 2.6}
        return [axes.axhline(value, label=label, **look) for value in values][:1]


DISTANCES = _Distances(
    {'D': distance_or_shape, 'WPL': points, 'REACHED': number}, {'WPL': None, 'REACHED': REACHED_M}
)
"""The task."""
