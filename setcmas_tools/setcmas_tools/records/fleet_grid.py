"""Motion of a fleet at common times, for distances between robots."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats
from setcmas_tools.records.fleet_table import FleetTable
from setcmas_tools.records.gaps import LONGEST_GAP_S
from setcmas_tools.records.track import Track


@dataclass(frozen=True)
class FleetGrid:
    """Poses at common times; NaN where a robot has none.

    Attributes:
        t: Times in s, shape (K,).
        robots: Numbers of the N robots, sorted.
        x: Positions in m, shape (N, K).
        y: Positions in m, shape (N, K).
        theta: Headings in rad, not wrapped, shape (N, K).
    """

    t: Floats
    robots: list[int]
    x: Floats
    y: Floats
    theta: Floats

    @property
    def complete(self) -> NDArray[np.bool_]:
        """Whether no robot is missing, shape (K,).

        A robot is missed between its first and its last pose, and for LONGEST_GAP_S beyond.
        Elsewhere it is not part of the fleet.
        """
        known = np.isfinite(self.x)
        seen = [self.t[row][[0, -1]] if row.any() else (np.inf, -np.inf) for row in known]
        first, last = np.array(seen).T[:, :, None]
        expected = (self.t >= first - LONGEST_GAP_S) & (self.t <= last + LONGEST_GAP_S)
        return np.asarray(np.all(known | ~expected, axis=0))

    def since(self, t: float) -> FleetGrid:
        """Return the samples from a time (s) on."""
        k = self.t >= t
        return FleetGrid(self.t[k], self.robots, self.x[:, k], self.y[:, k], self.theta[:, k])


def on_grid(table: FleetTable, rate: float = 10.0) -> FleetGrid:
    """Interpolate a table linearly at multiples of a period, but over no gap.

    Args:
        table: At least one row.
        rate: Samples a second.
    """
    first, last = np.ceil(table.t[0] * rate), np.floor(table.t[-1] * rate)
    t = np.arange(first, last + 1) / rate if first <= last else table.t[:1]
    robots = table.robots
    poses = np.array([_poses_at(t, Track(table.of(robot))) for robot in robots])
    return FleetGrid(t, robots, poses[:, 0], poses[:, 1], poses[:, 2])


def _poses_at(t: Floats, track: Track) -> Floats:
    poses = track.poses(t)
    # A reset between two times leaves the later one out: no line is to join them.
    later = np.searchsorted(t, track.rows.t[1:][track.put])
    poses[:, later[later < len(t)]] = np.nan
    return poses
