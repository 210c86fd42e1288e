"""The way of one robot: its poses at any time, between its samples, but over no gap."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats
from setcmas_tools.records.fleet_table import FleetTable
from setcmas_tools.records.gaps import LONGEST_GAP_S, resets

SAME_TIME_S = 1e-6
"""Times in tables have 6 decimals."""


class Track:
    """Where one robot was.

    Attributes:
        rows: Its rows with a pose, sorted by time.
        put: Between which of them it was put somewhere else, shape (rows - 1,).
    """

    def __init__(self, rows: FleetTable) -> None:
        """Take the rows of one robot."""
        self.rows = rows.rows(np.isfinite(rows.x + rows.y + rows.theta))
        self.put = resets(self.rows)
        self._gap: NDArray[np.bool_] = self.put | (np.diff(self.rows.t) > LONGEST_GAP_S)
        self._columns = (self.rows.x, self.rows.y, np.unwrap(self.rows.theta))

    def poses(self, t: Floats) -> Floats:
        """Return the poses at times in s: rows x, y, theta (not wrapped), shape (3, K).

        They are NaN before the first sample, after the last one, and in a gap.
        """
        known = self.rows.t
        if not len(known):
            return np.full((3, len(t)), np.nan)
        poses = np.array(
            [np.interp(t, known, one, left=np.nan, right=np.nan) for one in self._columns]
        )
        if len(known) > 1:
            after = np.clip(np.searchsorted(known, t), 1, len(known) - 1)
            inside = (known[after - 1] < t) & (t < known[after])
            poses[:, self._gap[after - 1] & inside] = np.nan
        return poses

    def speeds(self, t: Floats) -> Floats:
        """Return forward speeds in m/s and turn rates in rad/s at times in s, shape (2, K).

        A row tells them for the time since the row before. They are NaN where poses are.
        """
        result = np.full((2, len(t)), np.nan)
        known = np.isfinite(self.poses(t)[0])
        rows = np.searchsorted(self.rows.t, t[known] - SAME_TIME_S)
        rows = np.minimum(rows, len(self.rows.t) - 1)
        result[:, known] = self.rows.v[rows], self.rows.omega[rows]
        return result

    def newest(self, t: float) -> int:
        """Return the last row at or before a time in s; -1 if there is none."""
        return int(np.searchsorted(self.rows.t, t + SAME_TIME_S, side='right')) - 1

    def next(self, t: float) -> int:
        """Return the first row at or after a time in s; the number of rows if there is none."""
        return int(np.searchsorted(self.rows.t, t - SAME_TIME_S))

    def is_broken(self, since: float, t: float) -> bool:
        """Return whether there is a gap between two times in s, the first one left out."""
        first, last = self.newest(since), self.next(t)
        return bool(self._gap[max(0, first) : last].any())
