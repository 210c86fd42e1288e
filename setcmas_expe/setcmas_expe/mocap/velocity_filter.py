"""Velocity filter: differences of poses, smoothed."""

from __future__ import annotations

import math

from setcmas_expe.mocap.sample import Pose, Sample
from setcmas_simu.robots.unicycle import velocities_between

_TIME_CONSTANT_S = 0.1
_SHORTEST_STEP_S = 1e-3
_LONGEST_STEP_S = 1.0


class VelocityFilter:
    """Estimates forward speed and turn rate of one robot.

    Backward differences through a first-order low-pass filter, exact for any step (Astrom and
    Wittenmark, Computer-Controlled Systems, 1997, section 2.3).
    """

    def __init__(self) -> None:
        self._last: tuple[float, Pose] | None = None
        self._V = self._omega = 0.0

    def update(self, sample: Sample, now: float) -> tuple[float, float]:
        """Return forward speed (m/s) and turn rate (rad/s).

        Args:
            sample: The measurement, Z-up.
            now: Time of arrival on a steady clock, in s.
        """
        self._difference(sample.planar(), sample.stamp or now)
        return self._V, self._omega

    def _difference(self, pose: Pose, time: float) -> None:
        if self._last is not None:
            step = time - self._last[0]
            if 0.0 <= step < _SHORTEST_STEP_S:  # a repeated stamp
                return
            if step < 0.0 or step > _LONGEST_STEP_S:  # a gap, or a clock that was set
                self._V = self._omega = 0.0
            else:
                V, omega = map(float, velocities_between(self._last[1], pose, step))
                share = 1.0 - math.exp(-step / _TIME_CONSTANT_S)
                self._V += share * (V - self._V)
                self._omega += share * (omega - self._omega)
        self._last = time, pose
