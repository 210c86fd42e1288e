"""Projection of velocities onto the constraints: the smallest change, by a quadratic program."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.filter.barrier_constraints import Constraints, Indices
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import needs

_SOLVED = 1
_TOLERANCE = 2e-6  # the solver's is 1e-6
_ALMOST = 1.001
_SAME = 1e-9  # m/s
_MOST_ROUNDS = 50

Mask = NDArray[np.bool_]


class Projection:
    """Finds the closest velocities that satisfy all constraints, period after period.

    The program only has constraints that the solution without them violates, and those active in
    the previous period; speed limits enter as tangents to circles. So velocities that violate no
    constraint stay unchanged to the last bit.
    """

    def __init__(self) -> None:
        """Begin without a previous period, or raise SetcmasError."""
        with needs('filter'):
            import daqp  # noqa: F401
        self._pairs: Indices = np.zeros(0, dtype=np.intp)
        self._others = np.zeros(0, dtype=bool)

    def __call__(
        self, wanted: Floats, constraints: Constraints, fastest: Floats, near: Indices
    ) -> Floats | None:
        """Return the velocities, shape (2, N); None if the constraints are infeasible.

        Args:
            wanted: Rows vx, vy in m/s, shape (2, N).
            constraints: Those of pairs, then others, always in the same order.
            fastest: Speed limits in m/s, at least the wanted speeds, shape (N,).
            near: Sorted indices of the pairs that have a constraint.
        """
        nb_rows = len(constraints.b)
        active = self._guess(near, nb_rows - len(near))
        velocities: Floats = wanted.copy()
        used = active.copy()
        for _ in range(_MOST_ROUNDS):
            constraints, broken = _broken(velocities, constraints, fastest)
            if not broken.any():
                self._pairs = near[active[: len(near)]]
                self._others = active[len(near) : nb_rows]
                return velocities
            used, active = (_lengthened(mask, len(broken)) for mask in (used, active))
            used |= broken
            solved = _solved(wanted, constraints.selected(used), active[used])
            if solved is None:
                return None
            velocities, active = solved[0], np.zeros(len(used), dtype=bool)
            active[used] = solved[1]
        return None

    def _guess(self, near: Indices, nb_others: int) -> Mask:
        """Guess the active constraints: those active in the previous period."""
        same = len(self._others) == nb_others
        others = self._others if same else np.zeros(nb_others, dtype=bool)
        return np.concatenate([np.isin(near, self._pairs, assume_unique=True), others])


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


def _lengthened(mask: Mask, length: int) -> Mask:
    return np.append(mask, np.zeros(length - len(mask), dtype=bool))


def _solved(wanted: Floats, constraints: Constraints, active: Mask) -> tuple[Floats, Mask] | None:
    """Return the velocities of all points, and the active constraints; None if infeasible."""
    import daqp

    points = np.flatnonzero(constraints.has_constraint(wanted.shape[1]))
    places = np.zeros(points[-1] + 1, dtype=np.intp)
    places[points] = np.arange(len(points))
    matrix = constraints.matrix(places, len(points))
    own = wanted[:, points]
    none = np.zeros(len(constraints.b), dtype=np.intc)
    for sense in (active.astype(np.intc), none) if active.any() else (none,):
        solution, _, status, info = daqp.solve(
            np.eye(2 * len(points)),
            -own.T.ravel(),
            matrix,
            constraints.b,
            np.full(len(constraints.b), -np.inf),
            sense,
        )
        if status == _SOLVED:
            velocities: Floats = wanted.copy()
            found = np.reshape(solution, (-1, 2)).T
            velocities[:, points] = np.where(np.abs(found - own).max(axis=0) > _SAME, found, own)
            return velocities, np.asarray(info['lam']) > 0.0
    return None
