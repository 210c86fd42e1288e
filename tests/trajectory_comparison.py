"""Distance between two trajectories once a constant time shift is removed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

_SHIFTS_PER_SIDE = 50
_REFINEMENTS = 3


@dataclass(frozen=True)
class Comparison:
    """The best match of two trajectories.

    Attributes:
        rms: Root mean square of the distance in m.
        shift: What is added to the times of the second trajectory, in s.
    """

    rms: float
    shift: float


def compare(
    t: ArrayLike,
    positions: ArrayLike,
    other_t: ArrayLike,
    other_positions: ArrayLike,
    max_shift: float = 0.5,
) -> Comparison:
    """Return the RMS distance of two trajectories after the best constant time shift.

    The second one is interpolated linearly at the times of the first one that it covers.

    Args:
        t: Times in s, increasing, shape (K,).
        positions: Rows x, y in m, shape (2, K).
        other_t: Times in s, increasing, shape (L,).
        other_positions: Rows x, y in m, shape (2, L).
        max_shift: The shift is within +- this, in s.

    Raises:
        ValueError: The trajectories do not overlap in time for any shift.
    """
    first = np.asarray(t, dtype=float), np.asarray(positions, dtype=float)
    second = np.asarray(other_t, dtype=float), np.asarray(other_positions, dtype=float)
    best, half_width = 0.0, max_shift
    for _ in range(_REFINEMENTS):
        shifts = best + np.linspace(-half_width, half_width, 2 * _SHIFTS_PER_SIDE + 1)
        shifts = np.clip(shifts, -max_shift, max_shift)
        distances = np.array([_rms(first, second, shift) for shift in shifts])
        if np.all(np.isnan(distances)):
            raise ValueError('the trajectories do not overlap in time')
        best = float(shifts[np.nanargmin(distances)])
        half_width /= _SHIFTS_PER_SIDE / 2
    return Comparison(float(np.nanmin(distances)), best)


def _rms(first: tuple[Floats, Floats], second: tuple[Floats, Floats], shift: float) -> float:
    (t, positions), (other_t, other_positions) = first, second
    moved_t = other_t + shift
    covered = (t >= moved_t[0]) & (t <= moved_t[-1])
    if not covered.any():
        return float('nan')
    other = np.array([np.interp(t[covered], moved_t, row) for row in other_positions])
    return float(np.sqrt(np.mean(np.sum((positions[:, covered] - other) ** 2, axis=0))))
