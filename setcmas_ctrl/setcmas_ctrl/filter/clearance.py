"""Barrier certificates: constraints that keep points apart, inside the arena and off obstacles.

Each keeps a distance h >= 0 to what is not allowed, by dh/dt >= -gamma h (Wang, Ames, Egerstedt,
"Safety barrier certificates for collisions-free multirobot systems", T-RO 2017, arXiv 1609.00651,
there with the squared distance). A velocity that is held for a time s leaves
h(s) >= (1 - gamma s) h, since distances to convex sets are convex in s: so h stays above 0 with
sampled control, too, as long as gamma times the period is at most 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.filter.rows import NOBODY, Indices, Rows
from setcmas_simu.arrays import Floats
from setcmas_simu.world.arena import Arena
from setcmas_simu.world.obstacles import Obstacles

_RECOVERY = 0.1
"""Speed in m/s at which points that are nearer than allowed must go apart, at most."""

_MARGIN_M = 1e-5
"""What the tolerance of the solver may use up."""


@dataclass(frozen=True)
class Clearance:
    """What is kept free around robots.

    Attributes:
        separation: Least distance of the centres of two robots in m; half of it is the least
            one to an obstacle.
        gamma: How fast a distance that is left may be used up, in 1/s.
        ahead: How far the point of each robot is ahead of its centre in m, shape (N,).
        own: Which robots are decided about, shape (N,).
    """

    separation: float
    gamma: float
    ahead: Floats
    own: NDArray[np.bool_]

    @cached_property
    def _pairs(self) -> tuple[Indices, Indices]:
        """The pairs that count, an own robot first."""
        first, second = np.triu_indices(len(self.own), 1)
        counted = self.own[first] | self.own[second]
        first, second = first[counted], second[counted]
        swap = ~self.own[first]
        return np.where(swap, second, first), np.where(swap, first, second)

    def near(self, points: Floats, speed: float) -> Indices:
        """Return which of the pairs of points (2, N) need a constraint, their places.

        Others are so far from each other that points of at most this speed (m/s) cannot break it.
        """
        i, j = self._pairs
        used_up = 2.0 * speed / self.gamma * (1.0 if self.own.all() else 2.0)
        far = self.separation + 2.0 * self.ahead.max() + used_up + _MARGIN_M
        x, y = points
        return np.flatnonzero((x[j] - x[i]) ** 2 + (y[j] - y[i]) ** 2 < far * far)

    def of_pairs(self, points: Floats, centres: Floats, which: Indices) -> Rows:
        """Return the constraints of some pairs of points (2, N), by their places.

        What the point of an own robot and that of another process must do is halved between them.
        Points that have passed each other are to go back, along the line of the centres (2, N).
        """
        i, j = (ends[which] for ends in self._pairs)
        normal, distance = _apart(points, centres, i, j)
        bound = self._bound(distance - self.separation - self.ahead[i] - self.ahead[j])
        alone = ~self.own[j]
        return Rows(i, np.where(alone, NOBODY, j), normal, np.where(alone, 0.5 * bound, bound))

    def too_near(self, points: Floats, centres: Floats) -> Indices:
        """Return which robots' points are too near for their centres to stay apart, sorted."""
        i, j = self._pairs
        _, distance = _apart(points, centres, i, j)
        near = distance < self.separation + self.ahead[i] + self.ahead[j] - _MARGIN_M
        return np.union1d(i[near], j[near])

    def of_arena(self, points: Floats, arena: Arena) -> Rows:
        """Return the constraints of points (2, N) in an arena."""
        own = np.flatnonzero(self.own)
        x, y = points[:, own]
        sides = (
            ((1.0, 0.0), arena.xmax - x),
            ((-1.0, 0.0), x - arena.xmin),
            ((0.0, 1.0), arena.ymax - y),
            ((0.0, -1.0), y - arena.ymin),
        )
        return Rows.joined(
            [
                Rows.of_one(
                    own,
                    np.tile(np.array([normal]).T, len(own)),
                    self._bound(left - self.ahead[own]),
                )
                for normal, left in sides
            ]
        )

    def of_obstacles(self, points: Floats, obstacles: Obstacles) -> Rows:
        """Return the constraints of points (2, N) among obstacles: one a disc, one a side."""
        own = np.flatnonzero(self.own)
        parts = []
        for x, y, radius in obstacles.discs:
            parts.append(self._off(own, points, np.array([[x], [y]]), radius))
        for polygon in obstacles.polygons:
            for start, end in polygon.sides:
                nearest = nearest_points(points[:, own], np.array(start), np.array(end))
                parts.append(self._off(own, points, nearest, 0.0))
        return Rows.joined(parts)

    def _off(self, own: Indices, points: Floats, nearest: Floats, radius: float) -> Rows:
        offset = nearest - points[:, own]
        distance = np.maximum(np.hypot(*offset), 1e-9)
        left = distance - radius - 0.5 * self.separation - self.ahead[own]
        return Rows.of_one(own, offset / distance, self._bound(left))

    def _bound(self, left: Floats) -> Floats:
        return np.maximum(self.gamma * (left - _MARGIN_M), -_RECOVERY)


def _apart(points: Floats, centres: Floats, i: Indices, j: Indices) -> tuple[Floats, Floats]:
    """Return unit vectors between points, and distances, below 0 of points that crossed."""
    offset, between = points[:, j] - points[:, i], centres[:, j] - centres[:, i]
    crossed = (offset * between).sum(axis=0) < 0.0
    line = np.where(crossed, between, offset)
    normal = line / np.maximum(np.hypot(*line), 1e-9)
    distance = np.where(crossed, (offset * normal).sum(axis=0), np.hypot(*offset))
    return normal, distance


def nearest_points(points: Floats, start: Floats, end: Floats) -> Floats:
    """Return the points of a segment from start (2,) to end (2,) that are nearest to others.

    Args:
        points: The others, shape (2, N).
        start: One end.
        end: The other.

    Returns:
        Rows x, y, shape (2, N).
    """
    along = end - start
    share = along @ (points - start[:, None]) / (along @ along)
    nearest: Floats = start[:, None] + along[:, None] * np.clip(share, 0.0, 1.0)
    return nearest
