"""Reach of a robot: how far from its last poses it can be by now."""

from __future__ import annotations

import math
from collections import deque

from setcmas_expe.mocap.sample import Pose
from setcmas_simu.fleet.planar_pose import wrap_angle
from setcmas_simu.robots.velocity_limits import VelocityLimits

NOISE_M = 0.03
"""What a pose may differ by although the robot stands: noise, and a body that wobbles."""

BLIND_S = 0.8
"""Time in s after which an unseen robot has stopped, so that it cannot be further away."""

_NOISE_RAD = 0.25
_LATE_S = 0.1  # by which one pose may be later than another: it moves on meanwhile
_FASTER = 1.1  # wheels' radii
_WINDOW_S = 0.5


class Reach:
    """Remembers the good poses of half a second; all times in s on one steady clock.

    A pose must be in reach of the last one, and of that half a second ago: what is small from one
    frame to the next adds up to a speed that no robot has.
    """

    def __init__(self, limits: VelocityLimits) -> None:
        """Take how fast the robot is."""
        self._limits = limits
        self._poses: deque[tuple[float, Pose]] = deque()

    def of(self, seconds: float) -> float:
        """Return how far in m the robot may be from where it was seen some time ago."""
        step = min(max(0.0, seconds), BLIND_S) + _LATE_S
        return _FASTER * self._limits.V_max * step + NOISE_M

    def add(self, pose: Pose, measured: float) -> None:
        """Note a good pose and when it was measured."""
        self._poses.append((measured, pose))
        while self._poses[0][0] < measured - _WINDOW_S:
            self._poses.popleft()

    def start(self, pose: Pose, measured: float) -> None:
        """Begin anew with a pose, for the robot was carried there."""
        self._poses.clear()
        self.add(pose, measured)

    def holds(self, pose: Pose, measured: float) -> bool:
        """Return whether the robot can be at a pose (m, rad)."""
        if not self._poses:
            return True
        return self._near(*self._poses[0], pose, measured) and self._near(
            *self._poses[-1], pose, measured
        )

    def _near(self, then: float, old: Pose, pose: Pose, measured: float) -> bool:
        seconds = measured - then
        turned = abs(float(wrap_angle(pose[2] - old[2])))
        turn = self._limits.omega_max * (min(max(0.0, seconds), BLIND_S) + _LATE_S)
        return (
            math.hypot(pose[0] - old[0], pose[1] - old[1]) <= self.of(seconds)
            and turned <= _FASTER * turn + _NOISE_RAD
        )
