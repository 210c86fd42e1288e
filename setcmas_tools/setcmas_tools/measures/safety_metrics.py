"""Metrics of safety: separation, stops, and interventions of the filter."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from setcmas_ctrl.filter.barrier_constraints import nearest_points
from setcmas_ctrl.filter.filter_options import Verdict
from setcmas_simu.arrays import Floats
from setcmas_simu.robots.arena import Arena
from setcmas_simu.robots.models_by_name import UNICYCLE, shape_of
from setcmas_tools.measures.metric import Measured
from setcmas_tools.run.fleet_motion import FleetGrid
from setcmas_tools.run.run import Run, arena_of, models_of, obstacles_of
from setcmas_tools.run.run_records import MOVING, FilteredCommands, SafetyRecord

_MOST_TOUCHES = 3
"""Collisions that metrics.yaml lists; further ones are counted."""


def fleet_separation(run: Run) -> Measured | None:
    """Return distances between the robots of a run; None for one robot."""
    return separation(run.counted_grid, models_of(run))


def separation(grid: FleetGrid, models: Mapping[int, str] | None = None) -> Measured | None:
    """Return the smallest distance of two robots, their collisions, and the distance at the end.

    `first_collisions` has the two robots and the time in s of the first pairs that touched.
    Between two samples of the grid, motion is taken as straight, at constant speed. Robots touch
    as discs that are as large as the bodies of their models, unicycles by default. The end is the
    last sample with all robots known. None if no two robots are known at the same time.
    """
    radii = np.array([_radius((models or {}).get(robot, UNICYCLE)) for robot in grid.robots])
    least, when, pair = np.inf, np.nan, (0, 0)
    touched = []
    lasts = np.diff(grid.t, append=grid.t[-1:])
    for i, robot in enumerate(grid.robots[:-1]):  # all pairs at once would take gigabytes
        starts = np.array([grid.x[i + 1 :] - grid.x[i], grid.y[i + 1 :] - grid.y[i]])
        ends = np.concatenate([starts[..., 1:], starts[..., -1:]], axis=2)
        others, reach = grid.robots[i + 1 :], radii[i] + radii[i + 1 :]
        distances, nearest, contact = _passing(starts, ends, reach)
        j = int(np.argmin(distances.min(axis=1)))
        k = int(np.argmin(distances[j]))
        if distances[j, k] < least:
            least, pair = float(distances[j, k]), (robot, others[j])
            when = float(grid.t[k] + nearest[j, k] * lasts[k])
        touches = distances < reach[:, None]
        for j in np.flatnonzero(touches.any(axis=1)).tolist():
            k = int(np.argmax(touches[j]))
            t = float(grid.t[k] + contact[j, k] * lasts[k])
            touched.append((robot, others[j], round(t, 3)))
    if not np.isfinite(least):
        return None
    first = sorted(touched, key=lambda one: one[2])
    largest = distances_of_pairs(grid)[2][np.isfinite(grid.x).all(axis=0)]
    at_end = float(largest[-1]) if len(largest) else None
    values = {
        'least_separation_m': least,
        'least_separation_time_s': when,
        'least_separation_robots': pair,
        'largest_distance_at_end_m': at_end,
        'pairs_that_touched': len(touched),
        'first_collisions': first[:_MOST_TOUCHES],
    }
    lines = [
        f'least separation: {least:.2f} m at {when:.1f} s between robots {pair[0]} and {pair[1]}',
        'largest distance between two robots at the end: '
        f'{"-" if at_end is None else format(at_end, ".2f")} m',
    ]
    return Measured(values, lines + _collisions(first))


def _collisions(touched: list[tuple[int, int, float]]) -> list[str]:
    """Return a line on the first pairs that touched, if there are any."""
    if not touched:
        return []
    (i, j, t), more = touched[0], len(touched) - 1
    others = f', {more} more pair{"s" * (more > 1)} later' if more else ''
    return [f'collisions: robots {i} and {j} touched at {t:.1f} s{others}']


def _radius(model: str) -> float:
    """Return the radius in m of the disc that is as large as a model's body."""
    x, y = np.array(shape_of(model).body).T
    area = float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
    return math.sqrt(area / math.pi)


def _passing(starts: Floats, ends: Floats, radii: Floats) -> tuple[Floats, Floats, Floats]:
    """Return how M points pass the origin on straight ways in m, (2, M, K), with radii (M,).

    Where the end of a way is NaN, its start counts.

    Returns:
        The least distances in m, infinite where unknown, and the shares of the ways up to there,
        and up to the first point within the radius, if there is one; shapes (M, K).
    """
    steps = np.nan_to_num(ends - starts)
    lengths = np.maximum(np.hypot(*steps), np.finfo(float).tiny)
    along = -np.sum(starts * steps, axis=0) / lengths
    nearest = np.clip(along / lengths, 0.0, 1.0)
    distances = np.hypot(*(starts + nearest * steps))
    before = np.sqrt(np.maximum(radii[:, None] ** 2 - distances**2, 0.0)) / lengths
    contact = np.maximum(nearest - before, 0.0)
    return np.nan_to_num(distances, nan=np.inf), nearest, contact


def distances_of_pairs(grid: FleetGrid) -> tuple[Floats, Floats, Floats]:
    """Return the smallest, mean and largest distance of all pairs of robots in m over time.

    NaN where a robot is missing.
    """
    smallest = np.full(len(grid.t), np.nan)
    largest = smallest.copy()
    total, count = np.zeros(len(grid.t)), np.zeros(len(grid.t))
    for d in _distances_to_later_robots(grid):
        smallest = np.fmin(smallest, np.fmin.reduce(d))
        largest = np.fmax(largest, np.fmax.reduce(d))
        total += np.nansum(d, axis=0)
        count += np.isfinite(d).sum(axis=0)
    mean = np.divide(total, count, out=np.full(len(grid.t), np.nan), where=count > 0)
    for values in (smallest, mean, largest):
        values[~grid.complete] = np.nan
    return smallest, mean, largest


def _distances_to_later_robots(grid: FleetGrid) -> Iterator[Floats]:
    """Yield the distances of each robot in m; all pairs at once would take gigabytes."""
    for i in range(len(grid.robots) - 1):
        yield np.hypot(grid.x[i + 1 :] - grid.x[i], grid.y[i + 1 :] - grid.y[i])


def obstacle_distance(run: Run) -> Measured | None:
    """Return the least distance of a robot's centre from the obstacles of a run, 0 inside.

    None without obstacles.
    """
    obstacles, table, models = obstacles_of(run), run.counted, models_of(run)
    known = table.rows(np.isfinite(table.x + table.y))
    points = np.stack([known.x, known.y])
    inside = [obstacles.contain(x, y) for x, y in points.T.tolist()]
    distances = np.where(inside, 0.0, np.inf)
    for x, y, radius in obstacles.discs:
        outside = np.maximum(np.hypot(points[0] - x, points[1] - y) - radius, 0.0)
        distances = np.minimum(distances, outside)
    for start, end in (side for polygon in obstacles.polygons for side in polygon.sides):
        away = points - nearest_points(points, np.array(start), np.array(end))
        distances = np.minimum(distances, np.hypot(*away))
    if not np.isfinite(distances).any():
        return None
    nearest = int(np.argmin(distances))
    least, robot = float(distances[nearest]), int(known.robot[nearest])
    touched = least < _radius(models[robot])
    values = {
        'least_obstacle_distance_m': least,
        'least_obstacle_distance_robot': robot,
        'touched': touched,
    }
    line = f'least distance to an obstacle: {least:.2f} m from the centre of robot {robot}'
    return Measured(values, [f'{line}, which touched it' if touched else line])


def fleet_safety(run: Run) -> Measured | None:
    """Return the safety events from start to end of an experiment; None if the run was none.

    Times are sums over robots; those of the lab's arena and distance are None without these.
    """
    record = run.safety
    if record is None:
        return None
    grid, end = run.counted_grid, float(run.parameters.get('duration', np.inf))
    robots = [held(record, robot, end) for robot in np.unique(record.robot).tolist()]
    stops, stopped, overruled = (sum(column) for column in zip(*robots, strict=True))
    arena, least = arena_of(run), run.parameters.get('min_separation')
    values = {
        'stops': int(stops),
        'stopped_s': round(stopped, 3),
        'overruled_s': round(overruled, 3),
        'outside_arena_s': _time_outside(grid, arena) if arena else None,
        'too_near_s': _time_too_near(grid, float(least)) if least else None,
    }
    names = ('stopped', 'limited or paused', 'outside the arena', 'too near')
    times = dict(zip(names, [*values.values()][1:], strict=True))
    shown = [f'{name} {time:.1f} s' for name, time in times.items() if time is not None]
    events = ', '.join([f'{stops} stop{"s" if stops != 1 else ""}', *shown])
    return Measured(values, [f'safety: {events}'])


def held(record: SafetyRecord, robot: int, end: float) -> tuple[int, float, float]:
    """Return how often and how long (s) a robot was stopped, and how long it was overruled.

    Times of the record from 0 to `end` (s) count.
    """
    mine = (record.robot == robot) & (record.t >= 0) & (record.t <= end)
    t, moving = record.t[mine], record.state[mine] == MOVING
    lasts = np.diff(t, append=t[-1:])
    stops = int(np.count_nonzero(moving[:-1] & ~moving[1:]))
    return stops, float(lasts[~moving].sum()), float(lasts[record.overruled[mine] == 1].sum())


def _time_outside(grid: FleetGrid, arena: Arena) -> float:
    x, y = grid.x, grid.y
    outside = (x < arena.xmin) | (x > arena.xmax) | (y < arena.ymin) | (y > arena.ymax)
    return _time(grid.t, outside.sum(axis=0))


def _time_too_near(grid: FleetGrid, least: float) -> float:
    """Return how long pairs of robots were closer than a distance (m), summed over pairs."""
    near = np.zeros(len(grid.t))
    for distances in _distances_to_later_robots(grid):
        near += (distances < least).sum(axis=0)
    return _time(grid.t, near)


def _time(t: Floats, counts: Floats) -> float:
    return round(float((counts[:-1] * np.diff(t)).sum()), 3)


def fleet_filtering(run: Run) -> Measured | None:
    """Return the effects of a run's safety filter; None without one."""
    commands = run.commands
    if not isinstance(commands, FilteredCommands):
        return None
    robots = np.unique(commands.robot).tolist()
    overruled = {robot: _overruled_s(commands.of(robot)) for robot in robots}
    unsolved = commands.t[commands.verdict == Verdict.NO_SOLUTION]
    count = len(np.unique(unsolved))
    steps = f'{count} step{"s" if count != 1 else ""}'
    return Measured(
        {'overruled_s': overruled, 'steps_without_solution': count},
        [f'safety filter: no solution in {steps}, robots stopped'] if count else [],
        {'overruled\n(s)': ('.1f', overruled)},
    )


def _overruled_s(commands: FilteredCommands) -> float:
    """Return how long, in s, the filter changed the velocities of a robot."""
    held = (commands.t >= 0.0) & (commands.verdict >= Verdict.CHANGED)
    period = float(np.median(np.diff(commands.t))) if len(commands.t) > 1 else 0.0
    return round(float(held.sum()) * period, 3)
