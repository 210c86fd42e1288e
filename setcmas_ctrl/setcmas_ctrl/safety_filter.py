"""Safety filter: changes velocities as little as possible so that robots stay safe."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.filter.barrier_constraints import BarrierConstraints, Constraints, Indices
from setcmas_ctrl.filter.control_points import ControlPoints, check_motions
from setcmas_ctrl.filter.filter_options import SEPARATION_M, FilterOptions, Verdict
from setcmas_ctrl.velocity_conversion import VelocityConversion
from setcmas_simu.arrays import Floats, single_precision
from setcmas_simu.errors import SetcmasError, needs
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.robots.arena import Arena, Obstacles
from setcmas_simu.robots.model import RobotModel

_TOLERATED = 0.05
"""Margin in m/s over the speed of points, for the tolerance of the solver."""

STOPPED_S = 3.0
"""Time in s after which robots that the filter stops are reported."""

_STOPPED = 0.1  # share of the wanted speed below which a robot counts as stopped
_SLOWEST = 0.01  # m/s: a law with a lower speed wants its robot to stop


class Allowed(NamedTuple):
    """What the filter allows N robots for one period.

    Attributes:
        velocities: In m/s, in single precision, shape (2, N): the wanted ones, or those of control
            points instead.
        verdicts: Verdict on each wanted velocity, values of `Verdict`, shape (N,).
    """

    velocities: Floats
    verdicts: NDArray[np.int64]


class SafetyFilter:
    """Keeps the robots of a fleet apart, in their arena and off obstacles.

    Attributes:
        conversion: Converts what the filter allows, so that it knows how robots are commanded.
    """

    def __init__(
        self,
        options: FilterOptions,
        nb_robots: int,
        conversion: VelocityConversion,
        report: Callable[[str], None] = print,
    ) -> None:
        """Prepare for a fleet of N robots.

        `report` is called with a message about robots that start too close, or are kept stopped
        for long.

        Raises:
            SetcmasError: The solver is missing, or gamma is too large for this rate.
        """
        with needs('filter'):
            import daqp  # noqa: F401
        if options.gamma * conversion.Ts > 1.0:
            raise SetcmasError(
                f'gamma is {options.gamma:g}; it must be at most the control rate, '
                f'{1.0 / conversion.Ts:g} Hz, or robots could come too close within one period'
            )
        self.conversion = conversion
        self._options = options
        self._report = report
        self._obstacles = Obstacles.of(options.obstacles or '')
        self._watch = _StopWatch(nb_robots)
        self._points: ControlPoints  # `use` sets both
        self._barriers: BarrierConstraints
        self._started = False

    def use(self, models: Sequence[RobotModel]) -> None:
        """Set the models of the N robots.

        Raises:
            SetcmasError: The filter cannot handle some robots' motion.
        """
        check_motions(models)
        self.conversion.use(models)
        options = self._options
        separation = options.min_separation or SEPARATION_M
        self._points = ControlPoints(models)
        self._barriers = BarrierConstraints(separation, options.gamma, self._points.ahead)

    def __call__(self, wanted: Floats, poses: Floats, fastest: float) -> Allowed:
        """Return the velocities that robots may have until the next call.

        Args:
            wanted: Velocities in m/s, shape (2, N), as messages carry them.
            poses: Poses of the fleet, shape (3, N).
            fastest: Speed limit in m/s.
        """
        self._check_starts(poses)
        control_points, conversion = self._points, self.conversion
        Ts, accel = conversion.Ts, self._options.accel
        commands = conversion.follow(wanted, poses)
        driven = control_points.driven(commands, poses) if accel else wanted
        moved = control_points.velocities(driven, commands, poses, Ts)
        speeds = np.hypot(moved[0], moved[1])
        most = np.maximum(np.minimum(fastest, control_points.V_max), speeds)
        points = control_points.points(poses)
        reach = np.fmax.reduce(speeds, initial=fastest) + _TOLERATED
        near = self._barriers.near(points, reach)
        constraints = self._constraints(points, poses[:2], near)
        constrained = constraints.selected(constraints.excess(moved) > 0.0).has_constraint(
            len(most)
        )
        found: Floats | None = moved
        if constrained.any():
            aim = np.where(constrained, wanted, moved)  # as laws want if possible
            limits = control_points.limits(moved, commands, poses, Ts)
            last = conversion.last
            rises = [control_points.rises(moved, last, poses, accel * Ts)] if accel else []
            found = self._projected(
                aim, moved, Constraints.stacked([constraints, limits]), rises, most
            )
        allowed = self._allowed(wanted, moved, found)
        conversion(allowed.velocities, poses, allowed.verdicts, commands)
        self._report_stopped(wanted, allowed.velocities)
        return allowed

    def _allowed(self, wanted: Floats, moved: Floats, found: Floats | None) -> Allowed:
        """Return what to allow: `found` are the velocities of points that would move otherwise."""
        if found is None:
            verdicts = np.full(wanted.shape[1], Verdict.NO_SOLUTION, dtype=np.int64)
            return Allowed(np.zeros(wanted.shape), verdicts)
        changed = (found != moved).any(axis=0)
        verdicts = np.where(changed, Verdict.CHANGED, Verdict.KEPT)
        return Allowed(single_precision(np.where(changed, found, wanted)), verdicts)

    def _check_starts(self, poses: Floats) -> None:
        """Warn once, as soon as all poses are known, of robots too close for the guarantee."""
        if self._started or not np.isfinite(poses).all():
            return
        self._started = True
        near = self._barriers.too_near(self._points.points(poses), poses[:2])
        if len(near):
            separation = self._barriers.separation
            far = separation + 4.0 * self._points.ahead.max()
            robots = robots_in_words([int(robot) + 1 for robot in near])
            self._report(
                f'{robots} start too close to others: the safety filter guarantees '
                f'{separation:g} m only if they start {far:g} m apart'
            )

    def _report_stopped(self, wanted: Floats, allowed: Floats) -> None:
        if stopped := self._watch.update(wanted, allowed, self.conversion.Ts):
            self._report(
                f'the safety filter keeps {robots_in_words(stopped)} stopped: other robots, '
                'the arena or obstacles are in the way'
            )

    def _projected(
        self,
        aim: Floats,
        moved: Floats,
        constraints: Constraints,
        rises: list[Constraints],
        most: Floats,
    ) -> Floats | None:
        """Return the velocities closest to the aim; safety may exceed the acceleration limit."""
        found = projected(aim, Constraints.stacked([constraints, *rises]), most)
        if found is None and rises:
            found = projected(moved, constraints, most)
        return found

    def _constraints(self, points: Floats, centres: Floats, near: Indices) -> Constraints:
        barriers = self._barriers
        parts = [barriers.of_pairs(points, centres, near)]
        if self._options.arena:
            parts.append(barriers.of_arena(points, Arena(*self._options.arena)))
        if self._options.obstacles:
            parts.append(barriers.of_obstacles(points, self._obstacles))
        return Constraints.stacked(parts)


class _StopWatch:
    """Finds robots that stay stopped although their laws want them to move."""

    def __init__(self, nb_robots: int) -> None:
        self._stopped = self._reported = np.zeros(nb_robots, dtype=bool)
        self._unchanged_s = 0.0

    def update(self, wanted: Floats, allowed: Floats, Ts: float) -> list[int]:
        """Take the velocities (2, N) of a period of Ts s; return newly found robots.

        Robots that stop one after the other are returned together, once none has followed.
        """
        speeds = np.hypot(*wanted)
        stopped = (speeds > _SLOWEST) & (np.hypot(*allowed) < _STOPPED * speeds)
        is_same = np.array_equal(stopped, self._stopped)
        self._unchanged_s = self._unchanged_s + Ts if is_same else 0.0
        self._stopped = stopped
        if self._unchanged_s < STOPPED_S:
            return []
        new = stopped & ~self._reported
        self._reported = self._reported | stopped
        return [int(index) + 1 for index in np.flatnonzero(new)]


_SOLVED = 1
_TOLERANCE = 2e-6  # the solver's is 1e-6
_ALMOST = 1.001
_SAME = 1e-9  # m/s
_MOST_ROUNDS = 50


Mask = NDArray[np.bool_]


def projected(wanted: Floats, constraints: Constraints, fastest: Floats) -> Floats | None:
    """Return the velocities closest to the wanted ones that satisfy all constraints, (2, N).

    The quadratic program only has constraints that the solution without them violates; speed
    limits enter as tangents to circles. So velocities that violate no constraint stay unchanged
    to the last bit.

    Args:
        wanted: Rows vx, vy in m/s, shape (2, N).
        constraints: The constraints.
        fastest: Speed limits in m/s, at least the wanted speeds, shape (N,).

    Returns:
        The velocities; None if the constraints are infeasible.
    """
    velocities = wanted
    used = np.zeros(0, dtype=bool)
    for _ in range(_MOST_ROUNDS):
        constraints, broken = _broken(velocities, constraints, fastest)
        if not broken.any():
            return velocities
        broken[: len(used)] |= used
        used = broken
        solution = _solved(wanted, constraints.selected(used))
        if solution is None:
            break
        velocities = solution
    return None


def _broken(
    velocities: Floats, constraints: Constraints, fastest: Floats
) -> tuple[Constraints, Mask]:
    """Return the constraints, with tangents for points that are too fast, and a violation mask."""
    broken = constraints.excess(velocities) > _TOLERANCE
    speeds = np.hypot(velocities[0], velocities[1])
    fast = np.flatnonzero(speeds > fastest * _ALMOST)
    if not len(fast):
        return constraints, broken
    tangents = Constraints.of_single(fast, velocities[:, fast] / speeds[fast], fastest[fast])
    return Constraints.stacked([constraints, tangents]), np.append(
        broken, np.ones(len(fast), dtype=bool)
    )


def _solved(wanted: Floats, constraints: Constraints) -> Floats | None:
    """Return the velocities of all points; None if the constraints are infeasible."""
    import daqp

    points = np.flatnonzero(constraints.has_constraint(wanted.shape[1]))
    places = np.zeros(points[-1] + 1, dtype=np.intp)
    places[points] = np.arange(len(points))
    own = wanted[:, points]
    solution, _, status, _ = daqp.solve(
        np.eye(2 * len(points)),
        -own.T.ravel(),
        constraints.matrix(places, len(points)),
        constraints.b,
        np.full(len(constraints.b), -np.inf),
        np.zeros(len(constraints.b), dtype=np.intc),
    )
    if status != _SOLVED:
        return None
    velocities: Floats = wanted.copy()
    found = np.reshape(solution, (-1, 2)).T
    velocities[:, points] = np.where(np.abs(found - own).max(axis=0) > _SAME, found, own)
    return velocities
