"""Robots as a display sees them: smooth poses, speeds, which are lost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.planar_pose import wrap_angle
from setcmas_tools.measures import consensus_metrics
from setcmas_tools.run.fleet_motion import farthest_drive

LOST_S = 1.5
"""Silence in s from which a robot counts as lost."""
FORGOTTEN_S = 30.0
"""Silence in s from which a robot is not shown any more."""
MOVING_M_S = 0.005
"""Speed in m/s from which a robot counts as moving."""

_PERIODS_S = (0.02, 0.25)  # between these, motion from one pose to the next is smooth


@dataclass
class _Seen:
    """What is known of one robot; poses are (x, y, theta) in m and rad, times in s."""

    pose: tuple[float, float, float]
    before: tuple[float, float, float]
    time: float
    period: float
    speed: float


class FleetView:
    """The robots that have been seen."""

    def __init__(self) -> None:
        """Start without robots."""
        self._seen: dict[int, _Seen] = {}
        self._put: set[int] = set()

    @property
    def robots(self) -> list[int]:
        """The robots' numbers, sorted."""
        return sorted(self._seen)

    def see(self, robot: int, pose: tuple[float, float, float], speed: float, now: float) -> None:
        """Note where a robot is.

        Args:
            robot: Its number.
            pose: x, y in m and theta in rad; what is not finite is passed over.
            speed: Along its heading in m/s.
            now: Time in s.
        """
        if not np.isfinite(pose).all():
            return
        last = self._seen.get(robot)
        if last is None or now - last.time > LOST_S:
            self._put.add(robot)
            self._seen[robot] = _Seen(pose, pose, now, _PERIODS_S[0], speed)
            return
        step = max(now - last.time, 1e-3)
        distance = float(np.hypot(pose[0] - last.pose[0], pose[1] - last.pose[1]))
        period = min(max(step, _PERIODS_S[0]), _PERIODS_S[1])
        reset = distance > farthest_drive(max(abs(speed), abs(last.speed)), step)
        self._put |= {robot} if reset else set()
        self._seen[robot] = _Seen(pose, pose if reset else last.pose, now, period, speed)

    def take_put(self) -> set[int]:
        """Return the robots that did not drive to where they are since the last call."""
        put, self._put = self._put, set()
        return put

    def poses(self, now: float) -> Floats:
        """Return the poses to show, one period behind the newest ones, so that motion is smooth.

        Returns:
            Rows x, y in m and theta in rad, a column for each of `robots`.
        """
        result = np.empty((3, len(self._seen)))
        for column, robot in enumerate(self.robots):
            seen = self._seen[robot]
            share = min(1.0, max(0.0, (now - seen.time) / seen.period))
            turn = float(wrap_angle(seen.pose[2] - seen.before[2])) if share < 1.0 else 0.0
            result[:, column] = (
                seen.before[0] + share * (seen.pose[0] - seen.before[0]),
                seen.before[1] + share * (seen.pose[1] - seen.before[1]),
                seen.pose[2] - (1.0 - share) * turn,
            )
        return result

    def newest(self) -> Floats:
        """Return the newest poses, a column for each of `robots`."""
        result: Floats = np.array([self._seen[r].pose for r in self.robots]).reshape(-1, 3).T
        return result

    def speeds(self) -> Floats:
        """Return the speeds in m/s, one for each of `robots`."""
        return np.array([self._seen[robot].speed for robot in self.robots])

    def lost(self, now: float) -> NDArray[np.bool_]:
        """Return for each of `robots` whether it has been silent for too long."""
        return np.array([now - self._seen[robot].time > LOST_S for robot in self.robots], bool)

    def forget(self, now: float) -> None:
        """Drop the robots that have been silent for a long time."""
        silent = [r for r, seen in self._seen.items() if now - seen.time > FORGOTTEN_S]
        for robot in silent:
            del self._seen[robot]

    def disagreement(self, lost: NDArray[np.bool_]) -> float | None:
        """Return the disagreement in m of the robots that are not lost; None below two."""
        xy = self.newest()[:2, ~lost]
        return (
            float(consensus_metrics.disagreement(*xy[:, :, None])[0]) if xy.shape[1] > 1 else None
        )
