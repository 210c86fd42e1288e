"""Delay between the speeds of a robot in two runs."""

from __future__ import annotations

import numpy as np

from setcmas_simu.arrays import Floats

RATE_HZ = 10
"""Speeds a second."""

_LONGEST_DELAY_S = 10.0
_LEAST_LIKENESS = 0.5


def delay_of(simulated: Floats, measured: Floats) -> float | None:
    """Return how much later measured speeds are than simulated ones in s; None if not alike.

    The delay is where the correlation coefficients of speed and turn rate are largest in the mean
    (cross-correlation: Ljung, System Identification, 1999, section 6.1).

    Args:
        simulated: Rows of speeds and turn rates, 10 a second, shape (2, K).
        measured: The same of the other run, shape (2, L).
    """
    most, least = round(_LONGEST_DELAY_S * RATE_HZ), min(simulated.shape[1], measured.shape[1]) / 2
    found = {}
    for steps in sorted(range(-most, most + 1), key=abs):
        begin, late = max(0, -steps), max(0, steps)
        length = min(simulated.shape[1] - begin, measured.shape[1] - late)
        if length > max(least, 2):
            one, other = simulated[:, begin:][:, :length], measured[:, late:][:, :length]
            found[steps] = _likeness(one, other)
    best = max(found, key=lambda steps: found[steps], default=0)
    return best / RATE_HZ if found and found[best] >= _LEAST_LIKENESS else None


def _likeness(one: Floats, other: Floats) -> float:
    """Return the mean correlation coefficient of rows; rows that do not change do not count."""
    known = np.isfinite(one + other).all(axis=0)
    found = []
    for row, column in zip(one[:, known], other[:, known], strict=True):
        if len(row) > 2 and np.ptp(row) > 0.0 and np.ptp(column) > 0.0:
            found.append(float(np.corrcoef(row, column)[0, 1]))
    return float(np.mean(found)) if found else 0.0
