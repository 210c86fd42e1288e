"""Linear constraints on the velocities of points, each of one point or of a pair of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats

NOBODY = -1
"""Stands for the second point of a constraint that has none."""

Indices = NDArray[np.intp]


@dataclass(frozen=True)
class Rows:
    """Constraints a (u_i - u_j) <= b on velocities u in m/s; u_j is left out where j is NOBODY.

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
    def of_one(cls, i: Indices, a: Floats, b: Floats) -> Rows:
        """Return constraints of single points."""
        return cls(i, np.full(len(i), NOBODY), a, b)

    @classmethod
    def joined(cls, parts: Sequence[Rows]) -> Rows:
        """Return the constraints of all parts."""
        return cls(
            np.concatenate([part.i for part in parts]),
            np.concatenate([part.j for part in parts]),
            np.hstack([part.a for part in parts]),
            np.concatenate([part.b for part in parts]),
        )

    def excess(self, velocities: Floats) -> Floats:
        """Return by how much velocities (2, N) break each constraint, in m/s, shape (R,)."""
        known = np.hstack([velocities, np.zeros((2, 1))])  # NOBODY's is the last
        relative = known[:, self.i] - known[:, self.j]
        excess: Floats = self.a[0] * relative[0] + self.a[1] * relative[1] - self.b
        return excess

    def chosen(self, which: NDArray[np.bool_]) -> Rows:
        """Return some of them, chosen by a mask, shape (R,)."""
        return Rows(self.i[which], self.j[which], self.a[:, which], self.b[which])

    def has(self, nb_points: int) -> NDArray[np.bool_]:
        """Return which of the N points they are of, shape (N,)."""
        has = np.zeros(nb_points + 1, dtype=bool)  # NOBODY's is the last
        has[self.i] = has[self.j] = True
        return has[:-1]

    def matrix(self, places: Indices, nb_points: int) -> Floats:
        """Return them as a matrix on vx, vy of some points in turn, shape (R, 2 nb_points).

        Args:
            places: The place of each point among these, shape (N,).
            nb_points: Number of these.
        """
        matrix = np.zeros((len(self.i), 2 * nb_points))
        rows = np.arange(len(self.i))
        paired = self.j != NOBODY
        for axis in (0, 1):
            matrix[rows, 2 * places[self.i] + axis] = self.a[axis]
            second = 2 * places[self.j[paired]] + axis
            matrix[rows[paired], second] = -self.a[axis, paired]
        return matrix
