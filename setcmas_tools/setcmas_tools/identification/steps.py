"""Distances and turns of a robot over short windows, along its heading."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_tools.records.fleet_table import FleetTable
from setcmas_tools.records.gaps import gaps

WINDOW_S = 0.2
"""Time over which speeds are means: poses that are a little wrong make speeds very wrong."""


@dataclass(frozen=True)
class Steps:
    """Mean speeds over windows.

    Attributes:
        begin: When the windows begin in s, shape (K,).
        end: When they end in s, shape (K,).
        V: Mean forward speeds in m/s, shape (K,).
        omega: Mean turn rates in rad/s, shape (K,).
        overlap: How many windows lie over each other.
    """

    begin: Floats
    end: Floats
    V: Floats
    omega: Floats
    overlap: float

    @property
    def speeds(self) -> Floats:
        """Rows V and omega, shape (2, K)."""
        return np.array([self.V, self.omega])


def steps_of(track: FleetTable, since: float = 0.0) -> Steps:
    """Return the mean speeds of a robot in windows of `WINDOW_S`, one from each pose on.

    The forward way is the arc whose chord joins two poses, with the heading of its middle:
    s = (dx cos m + dy sin m) (a / sin a), m the mean of the headings, a half of their difference.

    Args:
        track: Its motion.
        since: When the first window begins, in s.
    """
    track = track.rows(np.isfinite(track.x + track.y + track.theta) & (track.t >= since))
    t, theta = track.t, np.unwrap(track.theta)
    last = np.searchsorted(t, t + WINDOW_S)
    first = np.flatnonzero(last < len(t))
    last = last[first]
    whole = np.concatenate([[0], np.cumsum(gaps(track))]) if len(t) else np.zeros(0)
    first, last = (ends[whole[first] == whole[last]] for ends in (first, last))
    first, last = (ends[t[last] - t[first] < 1.5 * WINDOW_S] for ends in (first, last))
    time = t[last] - t[first]
    middle, half = 0.5 * (theta[last] + theta[first]), 0.5 * (theta[last] - theta[first])
    dx, dy = track.x[last] - track.x[first], track.y[last] - track.y[first]
    arc = (dx * np.cos(middle) + dy * np.sin(middle)) / np.sinc(half / np.pi)
    overlap = max(1.0, float(np.median(last - first))) if len(first) else 1.0
    return Steps(t[first], t[last], arc / time, 2.0 * half / time, overlap)
