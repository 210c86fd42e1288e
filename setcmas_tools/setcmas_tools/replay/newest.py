"""The newest row of each robot in a table, at any time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats
from setcmas_tools.run.fleet_motion import LONGEST_GAP_S, SAME_TIME_S


class NewestRows:
    """Finds rows of a table that is sorted by time."""

    def __init__(self, t: Floats, robot: NDArray[np.int64]) -> None:
        """Take the columns of a table: times in s, and numbers of robots."""
        self._rows = {int(one): np.flatnonzero(robot == one) for one in np.unique(robot)}
        self._times = {one: t[rows] for one, rows in self._rows.items()}

    def row(self, robot: int, t: float, longest_s: float = LONGEST_GAP_S) -> int | None:
        """Return the last row of a robot at or before a time in s; None if it is too old.

        Args:
            robot: Its number.
            t: The time.
            longest_s: The age in s from which a row tells nothing any more.
        """
        if robot not in self._rows:
            return None
        times = self._times[robot]
        count = int(np.searchsorted(times, t + SAME_TIME_S, side='right'))
        if not count or t - times[count - 1] > longest_s:
            return None
        return int(self._rows[robot][count - 1])
