"""A run at any time: poses, trails, drawings, links, broadcasts, states."""

from __future__ import annotations

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_tools.replay.newest import NewestRows
from setcmas_tools.run.fleet_motion import Track
from setcmas_tools.run.law_output import Drawing, DrawnOverTime
from setcmas_tools.run.run import Run

TRAIL_STEP_S = 0.2
"""Time between two points of a trail."""


class RunHistory:
    """A run that can be looked at at any time in s from its first command.

    Attributes:
        run: The run.
        robots: Numbers of its N robots, sorted; columns are in this order.
        tracks: Where each of them was.
        t0: Begin: the first command, or the first pose after it.
        t1: End.
    """

    def __init__(self, run: Run) -> None:
        """Sort what happened by robot."""
        self.run = run
        self.robots = run.robots
        self.tracks = [Track(run.table.of(robot)) for robot in self.robots]
        first, self.t1 = float(run.table.t[0]), float(run.table.t[-1])
        self.t0 = max(first, 0.0) if self.t1 > 0.0 else first
        self._drawn = DrawnOverTime(run.drawings)
        safety = run.tables.safety
        self._safety = NewestRows(safety.t, safety.robot) if safety else None
        self._broadcasts = run.record.trigger_times if run.record else {}

    def poses(self, t: float) -> Floats:
        """Return rows x, y in m and theta in rad (not wrapped), shape (3, N); NaN in a gap."""
        return self.poses_at(np.array([t]))[:, 0]

    def poses_at(self, times: Floats) -> Floats:
        """Return the poses at K times, shape (3, K, N)."""
        return np.stack([track.poses(times) for track in self.tracks], axis=2)

    def newest(self, t: float) -> Floats:
        """Return the newest poses at a time, as they were heard, shape (3, N)."""
        result = np.full((3, len(self.robots)), np.nan)
        for column, track in enumerate(self.tracks):
            if (row := track.newest(t)) >= 0:
                rows = track.rows
                result[:, column] = rows.x[row], rows.y[row], rows.theta[row]
        return result

    def speeds(self, t: float) -> Floats:
        """Return forward speeds in m/s and turn rates in rad/s, shape (2, N)."""
        return self.speeds_at(np.array([t]))[:, 0]

    def speeds_at(self, times: Floats) -> Floats:
        """Return the speeds at K times, shape (2, K, N)."""
        return np.stack([track.speeds(times) for track in self.tracks], axis=2)

    def trails(self, t: float, length_s: float) -> tuple[Floats, Floats]:
        """Return where robots were in the last seconds.

        Returns:
            K times in s, a multiple of `TRAIL_STEP_S` each but for the last, t; and positions in
            m, shape (K, 2, N), NaN in gaps.
        """
        first = np.ceil(max(self.t0, t - length_s) / TRAIL_STEP_S - 1e-6)
        times = np.append(np.arange(first, np.ceil(t / TRAIL_STEP_S - 1e-6)) * TRAIL_STEP_S, t)
        return times, self.poses_at(times)[:2].transpose(1, 0, 2)

    def put(self, since: float, t: float) -> set[int]:
        """Return the robots that did not drive from where they were to where they are."""
        both = zip(self.robots, self.tracks, strict=True)
        return {robot for robot, track in both if track.is_broken(since, t)}

    def drawings(self, t: float) -> list[Drawing]:
        """Return what scripts had drawn at a time that was seen then: trails, then markers."""
        return [*self._drawn.trails(t), *self._drawn.markers(t)]

    def adjacency(self, t: float) -> Floats | None:
        """Return the weights of links: row i hears column j, by robots' numbers from 1.

        None if there is no record of communication: all robots know all poses.
        """
        record = self.run.record
        if record is None:
            return None
        size = max(self.robots[-1], int(record.changes[:, 1:3].max(initial=0)))
        return record.adjacency(t, size)

    def broadcast_ages(self, t: float) -> Floats:
        """Return how long ago each robot sent its state by event, in s, shape (N,); else inf."""
        ages = np.full(len(self.robots), np.inf)
        for column, robot in enumerate(self.robots):
            times = self._broadcasts.get(robot, np.empty(0))
            count = int(np.searchsorted(times, t, side='right'))
            if count:
                ages[column] = t - times[count - 1]
        return ages

    def safety(self, robot: int, t: float) -> tuple[str, bool] | None:
        """Return what an experiment let a robot do, and whether it overruled its law.

        None if it was no experiment, or if nothing tells.
        """
        record = self.run.tables.safety
        row = self._safety.row(robot, t) if self._safety else None
        if record is None or row is None:
            return None
        return record.state[row], bool(record.overruled[row])
