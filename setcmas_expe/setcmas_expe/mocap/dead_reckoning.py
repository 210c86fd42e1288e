"""Poses from wheel odometry, which counts from measured start poses."""

from __future__ import annotations

import cmath
import math
from dataclasses import replace

from setcmas_expe.mocap.sources import Sample
from setcmas_simu.fleet.planar_pose import Pose, motion_between, quaternion_of_yaw

MOST_DRIFT_M = 0.15
"""Estimated error in m at which a robot stops."""
LONGEST_S = 180.0
"""Time in s after which a robot stops, whatever the estimate."""

_PER_METRE = 0.01  # of the way: radii of wheels
_TURN_PER_METRE = 0.005  # rad
_TURN_PER_TURN = 0.01  # rad per rad: base of wheels
_OFF_S = 1.0  # of silence: shorter than any restart
_ORIGIN_M = 0.01


class DeadReckoning:
    """Places wheel odometry at a measured start pose, and estimates how far it has drifted.

    Errors of the wheels' radii and base add up, as in J. Borenstein and L. Feng, Measurement and
    correction of systematic odometry errors in mobile robots, IEEE Trans. Robot. Autom. 12(6),
    1996; the rates are those of a calibrated TurtleBot3 on a hard floor.

    Attributes:
        drift: Estimated error of the position in m.
        way: Way in m since the start.
    """

    def __init__(self, start: Pose) -> None:
        """Begin at x, y in m and heading in rad."""
        self.drift = self.way = 0.0
        self._start = start
        self._first: Pose | None = None
        self._last: Pose | None = None
        self._turn_error = 0.0
        self._moving_since: float | None = None
        self._time = 0.0
        self._placed = math.inf
        self._restarted = False

    def placed(self, sample: Sample, now: float) -> Sample:
        """Return a sample of wheel odometry in the frame of the start pose; now is in s."""
        pose = sample.planar()
        if not all(map(math.isfinite, pose)):
            return sample  # rejected by the checks of all poses
        if self._first is None or self._last is None:
            self._first = self._last = pose
        step, turned = motion_between(self._last, pose)
        is_back_at_zero = math.hypot(*pose[:2]) < _ORIGIN_M < step
        self._restarted |= is_back_at_zero and now - self._placed > _OFF_S
        self._last, self._placed = pose, now
        if self._moving_since is None and step + turned > 0:
            self._moving_since = now
        self._time = 0.0 if self._moving_since is None else now - self._moving_since
        self.way += step
        self._turn_error += _TURN_PER_METRE * step + _TURN_PER_TURN * turned
        self.drift += (_PER_METRE + self._turn_error) * step
        turn = self._start[2] - self._first[2]
        moved = complex(pose[0] - self._first[0], pose[1] - self._first[1])
        offset = moved * cmath.rect(1.0, turn)
        place = (self._start[0] + offset.real, self._start[1] + offset.imag, 0.0)
        z, w = quaternion_of_yaw(turn + pose[2])
        return replace(sample, position=place, orientation=(0.0, 0.0, z, w))

    @property
    def trouble(self) -> str:
        """Why its poses are not good enough any more; empty while they are."""
        if self._restarted:
            return (
                'its wheel odometry counts from 0 again (was it switched off and on?): put the '
                'robots at their start poses, and start again'
            )
        if self.drift <= MOST_DRIFT_M and self._time <= LONGEST_S:
            return ''
        return (
            f'wheel odometry may be {100 * self.drift:.0f} cm off after {self.way:.1f} m and '
            f'{self._time:.0f} s: put the robots at their start poses, and start again'
        )
