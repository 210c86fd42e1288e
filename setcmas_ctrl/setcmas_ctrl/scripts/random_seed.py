"""The random numbers that control scripts draw."""

from __future__ import annotations

import argparse
import random

import numpy as np

SEED = 0
"""Default seed: equal runs draw equal numbers."""

_LARGEST = 2**32 - 1


def seed(text: str) -> int:
    """Return a seed that every generator takes (type of an option)."""
    if not (text.isdecimal() and int(text) <= _LARGEST):
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number from 0 to {_LARGEST}")
    return int(text)


def seed_scripts(value: int) -> None:
    """Seed the generators that scripts use: those of `random` and `numpy.random`."""
    random.seed(value)
    np.random.seed(value)
