"""Groups of a study's runs, and quantiles of their numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from setcmas_simu.arrays import Floats


@dataclass(frozen=True)
class Group:
    """The runs of a study that differ in nothing but their seeds, or in names left aside.

    Attributes:
        values: What they have in common, by name.
        rows: Their places in the table, from 0.
    """

    values: Mapping[str, Any]
    rows: Sequence[int]


def runs_in_words(count: int, kind: str = '') -> str:
    """Return '1 run' or '20 runs', or those of a kind: '3 broken runs'."""
    name = f'{kind} run'.lstrip()
    return f'{count:,} {name}{"s" if count != 1 else ""}'


def median(values: Floats) -> float:
    """Return the median of values without NaN; inf is larger than all others."""
    return float(quantiles(values, 0.5)[0])


def quantiles(values: Floats, *shares: float) -> Floats:
    """Return quantiles of values without NaN, of which some may be inf; NaN if there are none.

    Source of the definition: inverse of the empirical distribution function, with the midpoint
    where it steps, so that half is the median; Hyndman and Fan, The American Statistician 50(4),
    1996, type 2. That of numpy makes NaN of inf.
    """
    known = np.sort(values[~np.isnan(values)])
    if not len(known):
        return np.full(len(shares), np.nan)
    places = len(known) * np.array(shares)
    below, above = np.ceil(places) - 1, np.minimum(np.floor(places), len(known) - 1)
    return np.asarray((known[below.astype(int)] + known[above.astype(int)]) / 2)
