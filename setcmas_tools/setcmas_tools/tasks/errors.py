"""Root mean squares of errors over the robots and the time of a run."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats


def rms_by_robot(t: Floats, errors: dict[int, Floats], share: float) -> dict[int, float]:
    """Return the RMS errors from a share of the run on, of the robots that are known there."""
    late = from_share(t, share)
    known = {robot: values[late & np.isfinite(values)] for robot, values in errors.items()}
    return {robot: rms(values) for robot, values in known.items() if len(values)}


def from_share(t: Floats, share: float) -> NDArray[np.bool_]:
    """Return which times are in a run from a share of it on."""
    if not len(t):
        return np.zeros(0, dtype=bool)
    begin = t[0] + share * (t[-1] - t[0])
    return np.asarray(t >= begin - 1e-9)


def rms(values: Floats | list[float]) -> float:
    """Return the root mean square of values."""
    return float(np.sqrt(np.mean(np.square(values))))
