"""History of a run: the newest pose and state of each robot at a time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats
from setcmas_tools.run.fleet_motion import LONGEST_GAP_S, SAME_TIME_S, Track
from setcmas_tools.run.run import Run


class RunHistory:
    """A run at any time in s from its first command.

    Attributes:
        robots: Numbers of its N robots, sorted; columns are in this order.
        tracks: Where each of them was.
        t0: Begin: the first command, or the first pose after it.
        t1: End.
    """

    def __init__(self, run: Run) -> None:
        self.run = run
        self.robots = run.robots
        self.tracks = [Track(run.table.of(robot)) for robot in self.robots]
        first, self.t1 = float(run.table.t[0]), float(run.table.t[-1])
        self.t0 = max(first, 0.0) if self.t1 > 0.0 else first
        safety = run.tables.safety
        self._safety = NewestRows(safety.t, safety.robot) if safety else None

    def poses_at(self, times: Floats) -> Floats:
        """Return the poses at K times, shape (3, K, N)."""
        return np.stack([track.poses(times) for track in self.tracks], axis=2)

    def speeds_at(self, times: Floats) -> Floats:
        """Return the speeds at K times, shape (2, K, N)."""
        return np.stack([track.speeds(times) for track in self.tracks], axis=2)

    def put(self, since: float, t: float) -> set[int]:
        """Return the robots that were moved, rather than drove, to their poses at a time."""
        both = zip(self.robots, self.tracks, strict=True)
        return {robot for robot, track in both if track.is_broken(since, t)}

    def safety(self, robot: int, t: float) -> tuple[str, bool] | None:
        """Return a robot's state in an experiment, and whether safety overruled its law.

        None if it was no experiment, or if it is not recorded.
        """
        record = self.run.tables.safety
        row = self._safety.row(robot, t) if self._safety else None
        if record is None or row is None:
            return None
        return record.state[row], bool(record.overruled[row])


class NewestRows:
    """Finds rows of a table that is sorted by time."""

    def __init__(self, t: Floats, robot: NDArray[np.int64]) -> None:
        """Take the columns of a table: times in s, and numbers of robots."""
        self._rows = {int(one): np.flatnonzero(robot == one) for one in np.unique(robot)}
        self._times = {one: t[rows] for one, rows in self._rows.items()}

    def row(self, robot: int, t: float) -> int | None:
        """Return the last row of a robot at or before a time in s; None if it is too old."""
        if robot not in self._rows:
            return None
        times = self._times[robot]
        count = int(np.searchsorted(times, t + SAME_TIME_S, side='right'))
        if not count or t - times[count - 1] > LONGEST_GAP_S:
            return None
        return int(self._rows[robot][count - 1])
