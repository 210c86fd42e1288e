"""Comparisons of a run with that of the solution: of positions, paths and answers.

Answers are compared at the calls of the submission: the solution gets the poses and messages that
the submission got, so that neither the paths nor the timing of earlier calls matter.
"""

from __future__ import annotations

from collections.abc import Callable, Collection

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_tools.compare.formation_shape import shape_distance
from setcmas_tools.compare.run_distance import distances_between
from setcmas_tools.offline.altered_solutions import SOLUTION, Altered, calls_of, saturated
from setcmas_tools.offline.fleet_laws import answers, load_laws
from setcmas_tools.offline.offline_communication import decisions
from setcmas_tools.run.fleet_motion import FleetGrid, FleetTable
from setcmas_tools.run.run import Run
from setcmas_tools.scenario.scenario import Scenario

COMPARED = {
    'path_error': ('m', 'RMS distance to the paths of the solution, at equal times'),
    'largest_path_error': ('m', 'largest distance to the paths of the solution'),
    'end_error': ('m', 'largest distance from a final position of the solution'),
    'shape_error': (
        'm',
        'RMS distance to the final formation, after moving, turning and relabelling it',
    ),
    'path_ratio': ('', 'total path length, divided by that of the solution'),
    'path_distance': (
        'm',
        'largest distance of a path from that of the solution, whatever the timing',
    ),
    'answer_error': ('', "relative difference between a law's results and those of the solution"),
    'direction_error': ('°', "angle between a law's velocities and those of the solution"),
}
"""Comparisons with the model solution: units and descriptions."""

OF_ANSWERS = ('answer_error', 'direction_error')
"""Comparisons that need the solution itself, not only its run."""

_DIGITS = 9
_DECIMALS = 6  # fewer than the last bits, in which machines and sandboxes differ
_LEAST_M_S = 0.05  # slower velocities do not count: laws may have dead bands
_STILL_M_S = 1e-3  # slower velocities have no direction
_EARLY_S = 1e-6  # a state at the time of a call is known to it


def compared(
    names: Collection[str], run: Run, solution: Run, right: Scenario, of_condition: bool
) -> dict[str, float | None]:
    """Return comparisons by name, with 9 digits; None for missing ones.

    Args:
        names: Which to return; others are ignored.
        run: The run of the submission.
        solution: The run of the solution.
        right: The scenario with the solution as its law, or as its condition.
        of_condition: Whether answers are those of the condition, or of the law.
    """
    _, apart = distances_between(run, solution)
    distances = np.array([*apart.values()])
    if not np.isfinite(distances).any():
        return dict.fromkeys(COMPARED.keys() & names)
    functions: dict[str, Callable[[], float | None]] = {
        'path_error': lambda: float(np.sqrt(np.nanmean(distances**2))),
        'largest_path_error': lambda: float(np.nanmax(distances)),
        'end_error': lambda: float(np.nanmax(distances[:, -1])),
        'shape_error': lambda: _shape_error(run, solution),
        'path_ratio': lambda: _ratio(run, solution),
        'path_distance': lambda: _path_distance(run, solution),
        'answer_error': lambda: _answer_error(run, right, of_condition),
        'direction_error': lambda: None if of_condition else _direction_error(run, right),
    }
    numbers = {name: functions[name]() for name in COMPARED if name in names}
    return {
        name: None if number is None else float(f'{number:.{_DIGITS}g}')
        for name, number in numbers.items()
    }


def _shape_error(run: Run, solution: Run) -> float | None:
    """Return the distance of the robots to the solution's shape at the end; None if unknown."""
    own, wanted = (
        np.column_stack([one.counted_grid.x[:, -1], one.counted_grid.y[:, -1]])
        for one in (run, solution)
    )
    if own.shape != wanted.shape or not np.isfinite([own, wanted]).all():
        return None
    return shape_distance(own, wanted)


def _ratio(run: Run, solution: Run) -> float | None:
    own, wanted = (_length(one.counted_grid) for one in (run, solution))
    return own / wanted if wanted else None


def _length(grid: FleetGrid) -> float:
    """Return the total path length of all robots in m."""
    return float(np.nansum(np.hypot(np.diff(grid.x), np.diff(grid.y))))


def _path_distance(run: Run, solution: Run) -> float:
    """Return the largest distance of a robot's path to that of the solution in m."""
    own, wanted = (_paths(one.counted_grid) for one in (run, solution))
    robots = own.keys() & wanted.keys()
    return round(max(frechet_distance(own[i], wanted[i]) for i in robots), _DECIMALS)


def _paths(grid: FleetGrid) -> dict[int, Floats]:
    """Return the known positions of each robot, shape (K, 2)."""
    rows = zip(grid.robots, grid.x, grid.y, strict=True)
    return {robot: np.column_stack([x, y])[np.isfinite(x + y)] for robot, x, y in rows}


def frechet_distance(first: Floats, second: Floats) -> float:
    """Return the discrete Fréchet distance of two paths up to where the first of them ends, in m.

    Both are walked along from their beginnings, never back, so that their largest distance is
    least; when one has ended, the rest of the other does not count.
    Source: Eiter and Mannila, Computing discrete Fréchet distance, TU Vienna, 1994.

    Args:
        first: Points x, y in m, shape (K, 2).
        second: Points of the other path, shape (M, 2).
    """
    size, other = len(first), len(second)
    gaps = np.hypot(*(first[:, None] - second).transpose(2, 0, 1))
    least = np.inf
    older, old = np.full(size + 1, np.inf), np.full(size + 1, np.inf)
    older[0] = 0.0  # before the first points
    for both in range(size + other - 1):  # the pairs of points i and both - i
        i = np.arange(max(0, both - other + 1), min(size - 1, both) + 1)
        new = np.full(size + 1, np.inf)
        before = np.minimum(np.minimum(old[i], old[i + 1]), older[i])
        new[i + 1] = np.maximum(gaps[i, both - i], before)
        ended = (i == size - 1) | (both - i == other - 1)
        least = min(least, np.min(new[i + 1][ended], initial=np.inf))
        older, old = old, new
    return float(least)


def _answer_error(run: Run, right: Scenario, of_condition: bool) -> float | None:
    error = (_sending_error if of_condition else _velocity_error)(run, right)
    return None if error is None else round(error, _DECIMALS)


def _velocity_error(run: Run, right: Scenario) -> float | None:
    """Return the median relative difference of velocities, of the robot where it is largest.

    The median leaves freedom in moments such as turns, and when a law changes its target.
    None without commands, or if the solution fails, where its own run does not lead.
    """
    errors = [_relative(own, wanted, right.law.vnom) for own, wanted in _velocities(run, right)]
    return max(errors, default=None)


def _direction_error(run: Run, right: Scenario) -> float | None:
    """Return the median angle between velocities in degrees, its mean over the robots.

    It does not depend on gains. None as for `_velocity_error`.
    """
    angles = [_angle(own, wanted) for own, wanted in _velocities(run, right)]
    return round(float(np.mean(angles)), _DECIMALS) if angles else None


def _velocities(run: Run, right: Scenario) -> list[tuple[Floats, Floats]]:
    """Return a robot's velocities and those of the solution, shape (C, 2), of each robot.

    Empty without commands, or if the solution fails.
    """
    if run.messages or not right.knows_all_poses:
        return _velocities_of_repeated(run, right)
    pairs = []
    laws = load_laws(right.law, len(run.robots)) if run.commands else []
    for robot, law in zip(run.robots, laws, strict=bool(laws)):
        assert run.commands
        own = run.commands.of(robot)
        wanted = answers(law, own.t, _poses(run, own.t))
        if wanted is None:
            return []
        pairs.append((np.column_stack([own.vx, own.vy]), wanted))
    return pairs


def _velocities_of_repeated(run: Run, right: Scenario) -> list[tuple[Floats, Floats]]:
    """Return the same from a repetition of the run, which gives laws what each robot receives.

    Empty if it cannot be repeated.
    """
    solution = Altered(SOLUTION, right.law.scripts().paths[0], is_kept=True)
    calls = calls_of('', right, run, False, [solution])
    if calls is None:
        return []
    return [(calls.own[:, i], calls.solution[:, i]) for i in range(len(run.robots))]


def _angle(own: Floats, wanted: Floats) -> float:
    """Return the median angle between velocities in degrees, both of shape (C, 2).

    Calls at which the solution is slow do not count; a robot without a velocity is wrong by 180.
    """
    cross = own[:, 0] * wanted[:, 1] - own[:, 1] * wanted[:, 0]
    apart = np.degrees(np.abs(np.arctan2(cross, np.sum(own * wanted, axis=1))))
    apart[np.hypot(*own.T) < _STILL_M_S] = 180.0
    counted = apart[np.hypot(*wanted.T) > _LEAST_M_S]
    return float(np.median(counted)) if len(counted) else 0.0


def _relative(own: Floats, wanted: Floats, vnom: float) -> float:
    """Return the median of |own - wanted| as a share of the faster; both have shape (C, 2).

    Slow velocities do not count, and saturated ones, which hide gains, only if all are.
    """
    speeds = np.hypot(*wanted.T)
    is_free = (speeds > _LEAST_M_S) & (speeds < vnom)
    apart = np.hypot(*(own - saturated(wanted, vnom)).T)
    faster = np.maximum(np.hypot(*own.T), np.minimum(speeds, vnom))
    counted = is_free if is_free.any() else faster > _LEAST_M_S
    shares = apart[counted] / faster[counted]
    return float(np.median(shares)) if len(shares) else 0.0


def _poses(run: Run, times: Floats) -> Floats:
    """Return the last poses before given times or at them, shape (C, 3, N)."""
    return np.stack([_at(run.table.of(robot), times)[:, :3] for robot in run.robots], axis=2)


def _at(track: FleetTable, times: Floats) -> Floats:
    """Return x, y, theta and the forward speed then, shape (C, 4)."""
    rows = np.searchsorted(track.t, times + _EARLY_S, side='right') - 1
    return np.column_stack([track.x, track.y, track.theta, track.v])[np.maximum(rows, 0)]


def _sending_error(run: Run, right: Scenario) -> float | None:
    """Return the share of wrong decisions among those at which a state is or must be sent.

    None without triggering conditions.
    """
    nb_wrong = nb_counted = 0
    if not run.record:
        return None
    for robot in run.robots:
        t, _, sent = run.record.triggers[run.record.triggers[:, 1] == robot].T
        does = sent == 1
        states = _at(run.table.of(robot), t)
        own = [message for message in run.messages if message.robot == robot]
        must = decisions(right.communication, len(run.robots), robot, t, states, does, own)
        nb_wrong += int(np.sum(does != must))
        nb_counted += int(np.sum(does | must))
    return nb_wrong / nb_counted if nb_counted else None
