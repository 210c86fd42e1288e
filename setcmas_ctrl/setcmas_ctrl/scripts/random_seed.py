"""Seed of the random numbers that control scripts draw."""

from __future__ import annotations

import random

import numpy as np

SEED = 0
"""Default seed: equal runs draw equal numbers."""


def seed_scripts(value: int) -> None:
    """Seed the generators that scripts use: those of `random` and `numpy.random`."""
    random.seed(value)
    np.random.seed(value)
