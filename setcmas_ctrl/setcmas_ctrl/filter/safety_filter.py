"""Safety filter: changes commands as little as possible so that robots stay safe."""

from __future__ import annotations

import enum
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.filter.barrier_constraints import BarrierConstraints, Constraints, Indices
from setcmas_ctrl.filter.control_points import ControlPoints, check_motions
from setcmas_ctrl.filter.filter_options import SEPARATION_M, FilterOptions
from setcmas_ctrl.filter.projection import Projection
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.robots.arena import Arena, Obstacles
from setcmas_simu.robots.model import RobotModel


class Verdict(enum.IntEnum):
    """What the safety filter did with a wanted velocity."""

    KEPT = 0
    CHANGED = 1
    NO_SOLUTION = 2


_TOLERATED = 0.05
"""Margin in m/s over the speed of points, for the tolerance of the solver."""

STOPPED_S = 3.0
"""Time in s after which robots that the filter stops are reported."""

_STOPPED = 0.1  # share of the wanted speed below which a robot counts as stopped
_SLOWEST = 0.01  # m/s: a law with a lower speed wants its robot to stop


@dataclass(frozen=True)
class Allowed:
    """What the filter allows R robots for one period.

    Attributes:
        commands: Speeds forward and to the left (m/s) and turn rates (rad/s), shape (3, R).
        velocities: In m/s, shape (2, R): the wanted ones, or those of control points instead.
        verdicts: Verdict on each wanted velocity, values of `Verdict`, shape (R,).
        stopped: Robots that the filter has kept stopped for `STOPPED_S`, each once.
    """

    commands: Floats
    velocities: Floats
    verdicts: NDArray[np.int64]
    stopped: list[int]


class SafetyFilter:
    """Keeps robots apart, in their arena and off obstacles."""

    def __init__(self, options: FilterOptions, robots: Sequence[int], nb_robots: int) -> None:
        """Prepare for R robots that this process commands, in a fleet of N.

        Robots of other processes are trusted to take their half of each constraint.
        """
        self._options = options
        self._robots = robots
        self._own = np.array(robots) - 1
        self._is_own = np.isin(np.arange(nb_robots), self._own)
        self._obstacles = Obstacles.of(options.obstacles or '')
        self._project = Projection()
        self._watch = _StopWatch(robots)
        self._points: ControlPoints  # `use` sets both
        self._barriers: BarrierConstraints
        self._started = False

    def use(self, models: Sequence[RobotModel]) -> None:
        """Set the models of the R robots.

        Raises:
            SetcmasError: The filter cannot handle some robots' motion, or their control points are
                so far ahead that they could pass each other.
        """
        check_motions(self._robots, models)
        options = self._options
        separation = options.min_separation or SEPARATION_M
        self._points = ControlPoints(self._own, len(self._is_own), models, options.lookahead)
        if self._points.ahead[self._own].max(initial=0.0) >= 0.5 * separation:
            raise SetcmasError(
                f'lookahead is {options.lookahead:g}; it must be less than half of '
                f'min_separation, which is {separation:g} m'
            )
        self._barriers = BarrierConstraints(
            separation, options.gamma, self._points.ahead, self._is_own
        )

    def start_warning(self, poses: Floats) -> str:
        """Return, once, a warning about robots too close for the guarantee; '' if none."""
        if self._started or not np.isfinite(poses).all():
            return ''
        self._started = True
        near = self._barriers.too_near(self._points.points(poses), poses[:2])
        if not len(near):
            return ''
        separation = self._barriers.separation
        far = separation + 4.0 * self._points.ahead.max()
        return (
            f'{robots_in_words([int(robot) + 1 for robot in near])} start too close to others: '
            f'the safety filter guarantees {separation:g} m only if they start {far:g} m apart'
        )

    def __call__(
        self,
        wanted: Floats,
        follow: Callable[[Floats], Floats],
        poses: Floats,
        fastest: float,
        before: Floats,
        Ts: float,
    ) -> Allowed:
        """Return the velocities that robots may have for one period.

        Args:
            wanted: Velocities in m/s, shape (2, R).
            follow: Returns commands (3, R) for velocities (2, R).
            poses: Poses of the fleet, shape (3, N).
            fastest: Speed limit in m/s.
            before: The previous commands, shape (3, R).
            Ts: The period in s.
        """
        control_points, own = self._points, self._own
        commands = control_points.within_limits(follow(wanted))
        driven = control_points.driven(commands, poses) if self._options.accel else wanted
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
            aim = moved.copy()  # a blocking robot goes as its law wants if possible
            aim[:, own] = np.where(constrained[own], wanted, moved[:, own])
            limits = control_points.limits(moved, commands, poses, Ts)
            accel = self._options.accel
            rises = [control_points.rises(moved, before, poses, accel * Ts)] if accel else []
            found = self._projected(
                aim, moved, Constraints.stacked([constraints, limits]), rises, most, near
            )
        allowed = np.zeros(moved.shape) if found is None else found
        changed = (allowed != moved).any(axis=0)[own]
        velocities = np.where(changed, allowed[:, own], wanted)
        verdicts = np.where((velocities != wanted).any(axis=0), Verdict.CHANGED, Verdict.KEPT)
        if found is None:
            verdicts[:] = Verdict.NO_SOLUTION
        if changed.any():
            safe = control_points.commands(allowed, poses, Ts)
            known = np.isfinite(safe).all(axis=0)  # a robot without a pose stops
            commands = np.where(changed, np.where(known, safe, 0.0), commands)
        return Allowed(commands, velocities, verdicts, self._watch.update(wanted, velocities, Ts))

    def _projected(
        self,
        aim: Floats,
        moved: Floats,
        constraints: Constraints,
        rises: list[Constraints],
        most: Floats,
        near: Indices,
    ) -> Floats | None:
        """Return the velocities closest to the aim; safety may exceed the acceleration limit."""
        found = self._project(aim, Constraints.stacked([constraints, *rises]), most, near)
        if found is None and rises:
            found = self._project(moved, constraints, most, near)
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

    def __init__(self, robots: Sequence[int]) -> None:
        self._robots = np.array(robots)
        self._stopped = self._reported = np.zeros(len(robots), dtype=bool)
        self._unchanged_s = 0.0

    def update(self, wanted: Floats, allowed: Floats, Ts: float) -> list[int]:
        """Take the velocities (2, R) of a period of Ts s; return newly found robots.

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
        found: list[int] = self._robots[new].tolist()
        return found
