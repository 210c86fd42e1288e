"""Motion of a fleet: its table, its gaps, the track of each robot, and poses at common times."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError

Table = TypeVar('Table', bound='RobotTable')


@dataclass(frozen=True, repr=False, eq=False)
class RobotTable:
    """Rows of robots, sorted by time and then by robot; each column has the shape (rows,).

    Attributes:
        t: Times in s from the first command of the run.
        robot: Numbers of the robots, from 1.
    """

    t: Floats
    robot: NDArray[np.int64]

    @classmethod
    def in_order(cls: type[Table], t: ArrayLike, robot: ArrayLike, *columns: ArrayLike) -> Table:
        """Return the table of columns whose rows are in any order."""
        numbers = np.asarray(robot, dtype=np.int64)
        order = np.lexsort((numbers, np.asarray(t)))
        return cls(*(np.asarray(column)[order] for column in (t, numbers, *columns)))

    @property
    def robots(self) -> list[int]:
        """The numbers of the robots, sorted."""
        return [int(robot) for robot in np.unique(self.robot)]

    def of(self: Table, robot: int) -> Table:
        """Return the rows of one robot."""
        return self.rows(self.robot == robot)

    def rows(self: Table, selection: NDArray[np.bool_] | NDArray[np.intp]) -> Table:
        """Return the rows that a mask, or indices, select."""
        return type(self)(*(column[selection] for column in vars(self).values()))

    def stacked(self) -> list[Floats] | None:
        """Return the columns, shape (K, N) each, of rows of N robots at K common times.

        None if the robots have rows at times of their own.
        """
        if not len(self.t) or len(self.t) % len(self.robots):
            return None
        columns = [column.reshape(-1, len(self.robots)) for column in vars(self).values()]
        t, robot = columns[:2]
        return columns if (robot == self.robots).all() and (t == t[:, :1]).all() else None

    def __repr__(self) -> str:
        """Return one line: arrays would fill the screen."""
        return f'{type(self).__name__}({rows_in_words(self.t, self.robots)})'


@dataclass(frozen=True, repr=False, eq=False)
class FleetTable(RobotTable):
    """Motion of the robots: a row for each odometry message.

    Attributes:
        x: Positions in m.
        y: Positions in m.
        theta: Headings in rad.
        v: Forward speeds in m/s.
        omega: Turn rates in rad/s.
    """

    x: Floats
    y: Floats
    theta: Floats
    v: Floats
    omega: Floats


def rows_in_words(t: Floats, robots: Sequence[int]) -> str:
    """Return what a table of robots at times holds, such as '404 rows, 4 robots, 0 to 10 s'."""
    times = f', {t[0]:g} to {t[-1]:g} s' if len(t) else ''
    return f'{len(t)} rows, {len(robots)} robot{"s" if len(robots) != 1 else ""}{times}'


def fleet_table(rows: ArrayLike) -> FleetTable:
    """Return the table of rows t, robot, x, y, theta, v, omega in any order, shape (rows, 7)."""
    t, robot, *rest = np.asarray(rows, dtype=float).reshape(-1, 7).T
    known = (np.where(np.abs(column) <= LARGEST, column, np.nan) for column in rest)
    return FleetTable.in_order(t, robot, *known)


LARGEST = 1e12
"""Largest number in m, rad or m/s that is one: squares of larger ones may be infinite."""


_MOST_ROBOT_SECONDS = 1e6  # 8 robots for 35 h, or 250 for an hour


def check_extent(table: FleetTable, source: Path) -> None:
    """Check that robots and duration fit into memory; raise SetcmasError otherwise."""
    duration = float(np.ptp(table.t)) if len(table.t) else 0.0
    if len(table.robots) * duration > _MOST_ROBOT_SECONDS:
        raise SetcmasError(
            f"'{source}' has {len(table.robots)} robots over {duration:g} s; their product must "
            f'be at most {_MOST_ROBOT_SECONDS:g} s'
        )


LONGEST_GAP_S = 1.0
"""Longest time between two samples to interpolate over."""

SAME_TIME_S = 1e-6
"""Times in tables have 6 decimals."""

_NOISE_M = 0.1
_LEAST_M_S = 1.0
_USUAL = 0.9  # share of steps that are no resets


def farthest_drive(speed: float, seconds: float | Floats) -> float | Floats:
    """Return the longest drive in m of a robot with a largest speed (m/s) and a time in s.

    A longer jump is a reset; the limit of the speed is twice that in its odometry.
    """
    return _NOISE_M + max(_LEAST_M_S, 2 * speed) * seconds


def resets(track: FleetTable) -> NDArray[np.bool_]:
    """Return whether a robot was reset between two of its rows, shape (rows - 1,).

    Odometry without speeds shows none: it has no limit to compare with. Tables have forward speeds
    only: the limit of robots that drive sideways is the speed of the fastest tenth of their steps.
    """
    speeds = np.abs(track.v[np.isfinite(track.v)])
    seconds = np.diff(track.t)
    if not (fastest := float(speeds.max(initial=0.0))) or not len(seconds):
        return np.zeros(len(seconds), bool)
    steps = np.hypot(np.diff(track.x), np.diff(track.y))
    usual = np.quantile(steps / np.maximum(seconds, SAME_TIME_S), _USUAL, method='lower')
    return np.asarray(steps > farthest_drive(max(fastest, float(usual)), seconds))


def gaps(track: FleetTable) -> NDArray[np.bool_]:
    """Return whether a path is unknown between two rows of a robot, shape (rows - 1,)."""
    return np.asarray((np.diff(track.t) > LONGEST_GAP_S) | resets(track))


class Track:
    """Poses of a robot over time.

    Attributes:
        rows: Its rows with a pose, sorted by time.
    """

    def __init__(self, rows: FleetTable) -> None:
        self.rows = rows.rows(np.isfinite(rows.x + rows.y + rows.theta))
        self._gap = gaps(self.rows)
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

        A row holds them for the time since the previous row. They are NaN where poses are.
        """
        result = np.full((2, len(t)), np.nan)
        known = np.isfinite(self.poses(t)[0])
        rows = np.searchsorted(self.rows.t, t[known] - SAME_TIME_S)
        rows = np.minimum(rows, len(self.rows.t) - 1)
        result[:, known] = self.rows.v[rows], self.rows.omega[rows]
        return result

    def is_broken(self, since: float, t: float) -> bool:
        """Return whether there is a gap after a time in s and up to another."""
        first = np.searchsorted(self.rows.t, since + SAME_TIME_S, side='right') - 1
        last = np.searchsorted(self.rows.t, t - SAME_TIME_S)
        return bool(self._gap[max(0, int(first)) : int(last)].any())


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

    def __repr__(self) -> str:
        """Return one line."""
        return f'FleetGrid({rows_in_words(self.t, self.robots)})'

    def since(self, t: float) -> FleetGrid:
        """Return the samples from a time (s) on."""
        k = self.t >= t
        return FleetGrid(self.t[k], self.robots, self.x[:, k], self.y[:, k], self.theta[:, k])


def held_poses(table: FleetTable, t: float, robots: Sequence[int]) -> Floats:
    """Return the last poses of robots at or before a time (s), shape (3, N); NaN without one."""
    poses = np.full((3, len(robots)), np.nan)
    for column, robot in enumerate(robots):
        rows = Track(table.of(robot)).rows
        if last := int(np.searchsorted(rows.t, t + SAME_TIME_S)):
            poses[:, column] = rows.x[last - 1], rows.y[last - 1], rows.theta[last - 1]
    return poses


def on_grid(table: FleetTable, rate: float = 10.0) -> FleetGrid:
    """Interpolate a table with rows linearly at multiples of 1/rate (Hz), but over no gap."""
    first, last = np.ceil(table.t[0] * rate), np.floor(table.t[-1] * rate)
    t = np.arange(first, last + 1) / rate if first <= last else table.t[:1]
    robots = table.robots
    poses = np.array([_poses_at(t, Track(table.of(robot))) for robot in robots])
    return FleetGrid(t, robots, poses[:, 0], poses[:, 1], poses[:, 2])


def _poses_at(t: Floats, track: Track) -> Floats:
    poses = track.poses(t)
    # No line may join the poses before and after a reset: leave the later one out.
    later = np.searchsorted(t, track.rows.t[1:][resets(track.rows)])
    poses[:, later[later < len(t)]] = np.nan
    return poses
