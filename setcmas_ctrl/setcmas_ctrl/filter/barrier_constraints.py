"""Barrier constraints: keep points apart, in the arena, off obstacles; check of start poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.filter.filter_options import SEPARATION_M, FilterOptions
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError, needs
from setcmas_simu.robots.arena import Arena, Obstacles

NO_POINT = -1
"""Index in place of the second point in constraints of one point."""

Indices = NDArray[np.intp]


@dataclass(frozen=True)
class Constraints:
    """Constraints a (u_i - u_j) <= b on velocities u in m/s; without u_j where j is NO_POINT.

    Attributes:
        i: First points, shape (R,).
        j: Second points, shape (R,).
        a: Normals, shape (2, R).
        b: Bounds in m/s, shape (R,).
    """

    i: Indices
    j: Indices
    a: Floats
    b: Floats

    @classmethod
    def of_single(cls, i: Indices, a: Floats, b: Floats) -> Constraints:
        """Return constraints of single points."""
        return cls(i, np.full(len(i), NO_POINT), a, b)

    @classmethod
    def stacked(cls, parts: Sequence[Constraints]) -> Constraints:
        """Return the constraints of all parts."""
        return cls(
            np.concatenate([part.i for part in parts]),
            np.concatenate([part.j for part in parts]),
            np.hstack([part.a for part in parts]),
            np.concatenate([part.b for part in parts]),
        )

    def excess(self, velocities: Floats) -> Floats:
        """Return how much velocities (2, N) violate each constraint, in m/s, shape (R,)."""
        known = np.hstack([velocities, np.zeros((2, 1))])  # the last column is NO_POINT's
        relative = known[:, self.i] - known[:, self.j]
        excess: Floats = self.a[0] * relative[0] + self.a[1] * relative[1] - self.b
        return excess

    def selected(self, which: NDArray[np.bool_]) -> Constraints:
        """Return the constraints in a mask, shape (R,)."""
        return Constraints(self.i[which], self.j[which], self.a[:, which], self.b[which])

    def has_constraint(self, nb_points: int) -> NDArray[np.bool_]:
        """Return a mask of the N points that have a constraint, shape (N,)."""
        mask = np.zeros(nb_points + 1, dtype=bool)  # the last entry is NO_POINT's
        mask[self.i] = mask[self.j] = True
        return mask[:-1]

    def matrix(self, places: Indices, nb_points: int) -> Floats:
        """Return the constraints as a matrix on vx, vy of some points, shape (R, 2 nb_points).

        `places` are the indices of the N points among these.
        """
        matrix = np.zeros((len(self.i), 2 * nb_points))
        rows = np.arange(len(self.i))
        paired = self.j != NO_POINT
        for axis in (0, 1):
            matrix[rows, 2 * places[self.i] + axis] = self.a[axis]
            second = 2 * places[self.j[paired]] + axis
            matrix[rows[paired], second] = -self.a[axis, paired]
        return matrix


_RECOVERY = 0.1
"""Largest speed in m/s at which points that are too close must separate."""

_MARGIN_M = 1e-5
"""Margin for the tolerance of the solver."""


@dataclass(frozen=True)
class BarrierConstraints:
    """Distances to keep around robots.

    Attributes:
        separation: Minimum distance between the centres of two robots in m; half of it is the
            minimum distance to obstacles.
        gamma: Rate at which robots may use up the remaining distance, in 1/s.
        ahead: Distance from each robot's centre to its control point in m, shape (N,).
    """

    separation: float
    gamma: float
    ahead: Floats

    @cached_property
    def _pairs(self) -> tuple[Indices, Indices]:
        """All pairs of robots."""
        return np.triu_indices(len(self.ahead), 1)

    def near(self, points: Floats, speed: float) -> Indices:
        """Return the indices of the pairs of points (2, N) that need a constraint.

        Other pairs are too far apart for points of at most this speed (m/s) to break it.
        """
        i, j = self._pairs
        far = self.separation + 2.0 * (self.ahead.max() + speed / self.gamma) + _MARGIN_M
        x, y = points
        return np.flatnonzero((x[j] - x[i]) ** 2 + (y[j] - y[i]) ** 2 < far * far)

    def of_pairs(self, points: Floats, centres: Floats, which: Indices) -> Constraints:
        """Return the constraints of some pairs of points (2, N), by their indices.

        Points that have passed each other must go back, along the line of the centres (2, N).
        """
        i, j = (ends[which] for ends in self._pairs)
        normal, distance = _apart(points, centres, i, j)
        left = distance - self.separation - self.ahead[i] - self.ahead[j]
        return Constraints(i, j, normal, self._bound(left))

    def too_near(self, points: Floats, centres: Floats) -> Indices:
        """Return the robots whose control points are too close for their centres to stay apart."""
        i, j = self._pairs
        _, distance = _apart(points, centres, i, j)
        near = distance < self.separation + self.ahead[i] + self.ahead[j] - _MARGIN_M
        return np.union1d(i[near], j[near])

    def of_arena(self, points: Floats, arena: Arena) -> Constraints:
        """Return the constraints of points (2, N) in an arena."""
        every = np.arange(points.shape[1])
        x, y = points
        sides = (
            ((1.0, 0.0), arena.xmax - x),
            ((-1.0, 0.0), x - arena.xmin),
            ((0.0, 1.0), arena.ymax - y),
            ((0.0, -1.0), y - arena.ymin),
        )
        parts = []
        for normal, left in sides:
            normals = np.tile(np.array([normal]).T, len(every))
            parts.append(Constraints.of_single(every, normals, self._bound(left - self.ahead)))
        return Constraints.stacked(parts)

    def of_obstacles(self, points: Floats, obstacles: Obstacles) -> Constraints:
        """Return the constraints of points (2, N) among obstacles: one per disc, one per side."""
        parts = []
        for x, y, radius in obstacles.discs:
            parts.append(self._off(points, np.array([[x], [y]]), radius))
        for polygon in obstacles.polygons:
            for start, end in polygon.sides:
                nearest = nearest_points(points, np.array(start), np.array(end))
                parts.append(self._off(points, nearest, 0.0))
        return Constraints.stacked(parts)

    def _off(self, points: Floats, nearest: Floats, radius: float) -> Constraints:
        offset = nearest - points
        distance = np.maximum(np.hypot(*offset), 1e-9)
        left = distance - radius - 0.5 * self.separation - self.ahead
        every = np.arange(points.shape[1])
        return Constraints.of_single(every, offset / distance, self._bound(left))

    def _bound(self, left: Floats) -> Floats:
        return np.maximum(self.gamma * (left - _MARGIN_M), -_RECOVERY)


def _apart(points: Floats, centres: Floats, i: Indices, j: Indices) -> tuple[Floats, Floats]:
    """Return unit vectors between points, and distances, negative for points that crossed."""
    offset, between = points[:, j] - points[:, i], centres[:, j] - centres[:, i]
    crossed = (offset * between).sum(axis=0) < 0.0
    line = np.where(crossed, between, offset)
    normal = line / np.maximum(np.hypot(*line), 1e-9)
    distance = np.where(crossed, (offset * normal).sum(axis=0), np.hypot(*offset))
    return normal, distance


def nearest_points(points: Floats, start: Floats, end: Floats) -> Floats:
    """Return the points (2, N) of a segment between two ends (2,) closest to points (2, N)."""
    along = end - start
    share = along @ (points - start[:, None]) / (along @ along)
    return start[:, None] + along[:, None] * np.clip(share, 0.0, 1.0)


_ROUNDING_M = 1e-6


def check_starts(options: FilterOptions, poses: Floats) -> None:
    """Check, if the filter is on, that it is installed, and the start poses of a fleet, (3, N).

    Raises:
        SetcmasError: The solver is missing, or a robot starts outside the arena, inside an
            obstacle or too near another.
    """
    if not options.is_on:
        return
    with needs('filter'):
        import daqp  # noqa: F401
    obstacles = Obstacles.of(options.obstacles or '')
    for robot, (x, y) in enumerate(poses[:2].T.tolist(), start=1):
        at = f'robot {robot} starts at ({x:g}, {y:g}) m,'
        if options.arena and Arena(*options.arena).distance(x, y):
            raise SetcmasError(f'{at} outside the arena; move it, or enlarge the arena')
        if obstacles.contain(x, y):
            raise SetcmasError(f'{at} inside an obstacle; move it')
    separation = options.min_separation or SEPARATION_M
    i, j = np.triu_indices(poses.shape[1], 1)
    distances = np.hypot(*(poses[:2, j] - poses[:2, i]))
    for pair in np.flatnonzero(distances < separation - _ROUNDING_M)[:1]:
        raise SetcmasError(
            f'robots {i[pair] + 1} and {j[pair] + 1} start {distances[pair]:.3g} m apart; the '
            f'safety filter needs at least {separation:g} m: move them apart, or reduce '
            'min_separation'
        )
