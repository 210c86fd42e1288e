"""Comparisons of a run with that of the solution: of positions, paths and answers.

Answers are compared at the calls of the submission: the solution gets the poses and messages that
the submission got, so that neither the paths nor the timing of earlier calls matter.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from pathlib import Path

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.reports.script_calls import Function
from setcmas_tools.compare.run_distance import distances_between
from setcmas_tools.offline.altered_solutions import SOLUTION, Altered, Calls, calls_of, saturated
from setcmas_tools.run.fleet_motion import FleetGrid
from setcmas_tools.run.run import Run
from setcmas_tools.scenario.scenario import Scenario

COMPARED = {
    'path_error': ('m', 'RMS distance to the paths of the solution, at equal times'),
    'largest_path_error': ('m', 'largest distance to the paths of the solution'),
    'end_error': ('m', 'largest distance from a final position of the solution'),
    'path_ratio': ('', 'total path length, divided by that of the solution'),
    'path_distance': (
        'm',
        'largest distance of a path from that of the solution, whatever the timing',
    ),
    'answer_error': (
        '',
        "relative difference between a law's results and those of the solution in the same places",
    ),
    'direction_error': (
        '°',
        "angle between a law's velocities and those of the solution in the same places; a robot "
        'that stands, such as after an error, counts as 180°',
    ),
}
"""Comparisons with the model solution: units and descriptions."""

OF_ANSWERS = ('answer_error', 'direction_error')
"""Comparisons that need the solution itself, not only its run."""

_DIGITS = 9
_DECIMALS = 6  # fewer than the last bits, in which machines and sandboxes differ
_LEAST_M_S = 0.05  # slower velocities do not count: laws may have dead bands
_STILL_M_S = 1e-3  # slower velocities have no direction


def compared(
    names: Collection[str],
    run: Run,
    solution: Run,
    base: Scenario,
    script: Path | None,
    function: Function,
    robots: Sequence[int] = (),
) -> dict[str, float | None]:
    """Return comparisons by name, with 9 digits; None for missing ones.

    Args:
        names: Which to return; others are ignored.
        run: The run of the submission.
        solution: The run of the solution.
        base: The scenario without the submission.
        script: The solution; None is the default condition or si_to_uni, or unknown.
        function: What answers: a control law, a triggering condition, or si_to_uni.
        robots: Those whose answers are compared; empty for all.
    """
    _, apart = distances_between(run, solution)
    distances = np.array([*apart.values()])
    if not np.isfinite(distances).any():
        return dict.fromkeys(COMPARED.keys() & names)
    calls = None
    is_law = function is Function.CONTROL
    if {*OF_ANSWERS} & {*names} and (script or not is_law):
        right = Altered(SOLUTION, script, is_kept=True)
        calls = calls_of('', base, run, function, [right])
    if calls and robots:
        calls = calls.of_robots(np.isin(np.arange(calls.own.shape[1]) + 1, robots))
    of_answers: dict[str, Callable[[Calls], float | None]] = {
        'answer_error': _sending_error if function is Function.CONDITION else _velocity_error,
        'direction_error': _direction_error if is_law else (lambda _: None),
    }
    functions: dict[str, Callable[[], float | None]] = {
        'path_error': lambda: float(np.sqrt(np.nanmean(distances**2))),
        'largest_path_error': lambda: float(np.nanmax(distances)),
        'end_error': lambda: float(np.nanmax(distances[:, -1])),
        'path_ratio': lambda: _ratio(run, solution),
        'path_distance': lambda: _path_distance(run, solution),
    }
    numbers = {name: measured() for name, measured in functions.items() if name in names}
    for name, measured_in in of_answers.items():
        if name in names:
            numbers[name] = measured_in(calls) if calls else None
    return {
        name: None if number is None else float(f'{number:.{_DIGITS}g}')
        for name, number in numbers.items()
    }


def _ratio(run: Run, solution: Run) -> float | None:
    grids = (run.counted_grid, solution.counted_grid)
    own, wanted = (float(np.nansum(np.hypot(np.diff(g.x), np.diff(g.y)))) for g in grids)
    return own / wanted if wanted else None


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


def _velocity_error(calls: Calls) -> float:
    """Return the median relative difference of answers, of the robot where it is largest.

    The median leaves freedom in moments such as turns, and when a law changes its target.
    """
    errors = [_relative(*each, calls.limit) for each in _by_robot(calls)]
    return round(max(errors), _DECIMALS)


def _direction_error(calls: Calls) -> float:
    """Return the median angle between velocities in degrees, its mean over the robots.

    It does not depend on gains.
    """
    return round(float(np.mean([_angle(*each) for each in _by_robot(calls)])), _DECIMALS)


def _sending_error(calls: Calls) -> float:
    """Return the share of wrong decisions among those at which a state is or must be sent."""
    does, must = calls.own[..., 0] == 1, calls.solution[..., 0] == 1
    firsts = does.shape[1]  # which are sent whatever the condition is
    return round(float((does != must).sum() / (firsts + (does | must).sum())), _DECIMALS)


def _by_robot(calls: Calls) -> Iterator[tuple[Floats, Floats]]:
    """Yield each robot's velocities and those of the solution, shape (C, 2)."""
    for robot in range(calls.own.shape[1]):
        yield calls.own[:, robot], calls.solution[:, robot]


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
