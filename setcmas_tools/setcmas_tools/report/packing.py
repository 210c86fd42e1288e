"""Numbers of a run as short text: differences of whole numbers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from setcmas_simu.arrays import Floats

SCALE = 10_000
"""How many units of a packed number are 1: a tenth of a millimetre is kept."""

Packed = list[int | None]


def packed(values: Floats | Sequence[float]) -> Packed:
    """Return K numbers as differences to the known one before, in 1/`SCALE`; None for NaN."""
    numbers = np.asarray(values, dtype=float)
    known = np.flatnonzero(np.isfinite(numbers))
    steps = np.diff(np.round(numbers[known] * SCALE).astype(np.int64), prepend=0).tolist()
    result: Packed = [None] * len(numbers)
    for place, step in zip(known.tolist(), steps, strict=True):
        result[place] = step
    return result


def changes(values: Sequence[object]) -> list[tuple[int, object]]:
    """Return at which places a value begins, and the value, for a column that seldom changes."""
    return [
        (place, value)
        for place, value in enumerate(values)
        if not place or value != values[place - 1]
    ]
