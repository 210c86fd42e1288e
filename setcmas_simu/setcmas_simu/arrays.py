"""Arrays of real numbers, as a type."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def single_precision(numbers: Floats) -> Floats:
    """Return numbers as messages with single precision carry them, such as Point32."""
    return numbers.astype(np.float32).astype(float)
