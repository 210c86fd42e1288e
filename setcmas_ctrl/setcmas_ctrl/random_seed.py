"""The random numbers that control scripts draw."""

from __future__ import annotations

import random

import numpy as np

SEED = 0
"""Default seed: equal runs draw equal numbers."""

_LARGEST = 2**32 - 1


def seed(text: str) -> int:
    """Return a seed that every generator takes (type of an option).

    Raises:
        ValueError: It is not a whole number from 0 to 2^32 - 1.
    """
    value = int(text)
    if not 0 <= value <= _LARGEST:
        raise ValueError
    return value


def seed_scripts(value: int) -> None:
    """Seed the generators that scripts use: those of `random` and `numpy.random`."""
    random.seed(value)
    np.random.seed(value)
