"""Errors of a task over time: how far each robot is from what it should achieve."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.laws.references import Wanted
from setcmas_simu.arrays import Floats
from setcmas_tools.run.fleet_motion import FleetGrid
from setcmas_tools.run.run import Run

LEADER = 1
"""Number of the leader of a formation."""


@dataclass(frozen=True)
class Errors:
    """Errors of a task by robot, at the times of `Run.counted_grid`, in a unit ('m')."""

    title: str
    label: str
    unit: str
    values: Mapping[int, Floats]


def errors_of(run: Run) -> Errors | None:
    """Return the errors of a run's task over time; None if it has none at t >= 0."""
    if run.references is None or not len(run.counted.t):
        return None
    grid, task, wanted = run.counted_grid, run.references.task, run.references.values
    if task == 'tracking':
        found = tracking_errors(grid, wanted['R'], wanted['W'])
        return Errors('Tracking error', 'distance to the reference', 'm', found)
    if task == 'formation' and (found := place_errors(grid, np.array(wanted['PLACES']))):
        return Errors('Formation error', 'distance to the place', 'm', found)
    if task == 'distances' and len(found := distance_errors(grid, wanted['D'])) > 1:
        return Errors('Distance error', 'RMS error of the distances', 'm', found)
    if task == 'alignment' and (v := velocities(run)) is not None:
        gaps = np.hypot(*(v - v.mean(axis=1, keepdims=True)))
        found = dict(zip(grid.robots, gaps, strict=True))
        return Errors('Alignment error', 'distance to the mean velocity', 'm/s', found)
    return None


def tracking_errors(grid: FleetGrid, radius: float, rate: float) -> dict[int, Floats]:
    """Return the distance of each robot to r(t) = R (cos W t, sin W t) in m over time.

    The radius R is in m, the rate W in rad/s.
    """
    reference = radius * np.array([np.cos(rate * grid.t), np.sin(rate * grid.t)])
    return {
        robot: np.hypot(x - reference[0], y - reference[1])
        for robot, x, y in zip(grid.robots, grid.x, grid.y, strict=True)
    }


def place_errors(grid: FleetGrid, places: Floats) -> dict[int, Floats]:
    """Return the error |p_i - p_1 - d_i| of each follower in m over time.

    `places` (M, 2) are those of robots 2, 3, ... relative to the leader, in m; further robots have
    none. Nothing without a leader.
    """
    if LEADER not in grid.robots:
        return {}
    leader = grid.robots.index(LEADER)
    errors = {}
    for robot, x, y in zip(grid.robots, grid.x, grid.y, strict=True):
        if LEADER < robot <= LEADER + len(places):
            dx, dy = places[robot - LEADER - 1]
            errors[robot] = np.hypot(x - grid.x[leader] - dx, y - grid.y[leader] - dy)
    return errors


def distance_errors(grid: FleetGrid, wanted: Wanted) -> dict[int, Floats]:
    """Return the RMS error of each robot's distances to the others in m over time."""
    grid = placed(grid, wanted)
    matrix, errors = wanted_distances(grid.robots, wanted), {}
    for i, robot in enumerate(grid.robots):
        gaps = np.hypot(grid.x - grid.x[i], grid.y - grid.y[i]) - matrix[i, :, None]
        errors[robot] = np.sqrt(np.mean(np.delete(gaps, i, axis=0) ** 2, axis=0))
    return errors


def placed(grid: FleetGrid, wanted: Wanted) -> FleetGrid:
    """Return a grid without the robots that have no point in the wanted shape."""
    most = len(wanted) if isinstance(wanted, list) else math.inf
    kept = np.array(grid.robots) <= most
    robots = [robot for robot in grid.robots if robot <= most]
    return FleetGrid(grid.t, robots, grid.x[kept], grid.y[kept], grid.theta[kept])


def wanted_distances(robots: list[int], wanted: Wanted) -> Floats:
    """Return the wanted distances of robots in m, shape (N, N)."""
    if isinstance(wanted, list):
        x, y = np.reshape(wanted, (-1, 2))[np.array(robots, dtype=int) - 1].T
        return np.asarray(np.hypot(x - x[:, None], y - y[:, None]))
    return np.full((len(robots), len(robots)), wanted)


def velocities(run: Run) -> Floats | None:
    """Return the commands vx and vy in m/s at the times of `Run.counted_grid`, shape (2, N, K).

    None for one robot, or if the commands of a robot are unknown.
    """
    grid, commands = run.counted_grid, run.commands
    own = [commands.of(robot) for robot in grid.robots] if commands else []
    if len(own) < 2 or not all(len(one.t) for one in own):
        return None
    return np.array(
        [[np.interp(grid.t, one.t, getattr(one, name)) for one in own] for name in ('vx', 'vy')]
    )


def rms_by_robot(t: Floats, errors: Mapping[int, Floats], share: float) -> dict[int, float]:
    """Return RMS errors by robot after a share of the run, for robots with known errors."""
    late = from_share(t, share)
    known = {robot: values[late & np.isfinite(values)] for robot, values in errors.items()}
    return {robot: rms(values) for robot, values in known.items() if len(values)}


def from_share(t: Floats, share: float) -> NDArray[np.bool_]:
    """Return a mask of the times after a share of the run."""
    if not len(t):
        return np.zeros(0, dtype=bool)
    begin = t[0] + share * (t[-1] - t[0])
    return np.asarray(t >= begin - 1e-9)


def rms(values: Floats | list[float]) -> float:
    """Return the root mean square of values."""
    return float(np.sqrt(np.mean(np.square(values))))
