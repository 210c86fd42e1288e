"""Pose track of one robot: which measurements of motion capture to trust."""

from __future__ import annotations

import itertools
import math
import statistics
from collections import deque

from setcmas_expe.mocap.sample import Pose, PoseFault, Sample, fault_of, motion_between, text_of
from setcmas_expe.mocap.stamp_clock import StampClock
from setcmas_simu.robots.arena import Arena
from setcmas_simu.robots.model import VelocityLimits

TOO_SLOW_HZ = 4.0
"""Rate of measurements below which robots stop, in Hz: wrong ones are found too late then."""

_REMEMBERED = 20
_NOISE_M = 0.03  # largest distance between poses of a robot at rest: noise, and loose markers
_BLIND_S = 0.8  # after which an unseen robot has stopped
_NOISE_RAD = 0.25
_LATE_S = 0.1  # largest lateness of one pose compared with another
_FASTER = 1.1  # than its limits: the radii of wheels vary
_WINDOW_S = 0.5


class Reach:
    """How far from its recent poses a robot can be; all times in s on one steady clock.

    A pose must be in reach of the last pose and of that half a second ago: steps from frame to
    frame that are possible may add up to an impossible speed.
    """

    def __init__(self, limits: VelocityLimits) -> None:
        self._limits = limits
        self._poses: deque[tuple[float, Pose]] = deque()

    def add(self, pose: Pose, measured: float) -> None:
        """Note a good pose."""
        self._poses.append((measured, pose))
        while self._poses[0][0] < measured - _WINDOW_S:
            self._poses.popleft()

    def start(self, pose: Pose, measured: float) -> None:
        """Restart at the place to which the robot was carried."""
        self._poses.clear()
        self.add(pose, measured)

    def holds(self, pose: Pose, measured: float) -> bool:
        """Return whether the robot can be at a pose (m, rad)."""
        ends = (self._poses[0], self._poses[-1]) if self._poses else ()
        return all(self._near(then, old, pose, measured) for then, old in ends)

    def _near(self, then: float, old: Pose, pose: Pose, measured: float) -> bool:
        seconds = _FASTER * (min(max(0.0, measured - then), _BLIND_S) + _LATE_S)
        moved, turned = motion_between(old, pose)
        return (
            moved <= self._limits.V_max * seconds + _NOISE_M
            and turned <= self._limits.omega_max * seconds + _NOISE_RAD
        )


_LIFTED_M = 0.05  # from the usual height: the robot is off the floor
_SAME_FRAMES = 4
_FLOOR_S = 10.0  # time constant of the usual height: floors slope, calibrations too
_BAD_FOR_S = 0.1  # single bad frames are ignored
_STEADY_S = 1.0
_STEADY_M = 0.03
_STEADY_RAD = 0.2


class PoseTrack:
    """Judges measurements one by one; all times in s on one steady clock.

    Attributes:
        pose: The last good pose (x, y in m, heading in rad); None before the first.
        measured: When it was measured, by arrival and stamp; -inf before the first.
        fault: Why poses are rejected now; None if they are not.
        trouble: The same for people; empty if they are not.
        height: Height of its body in m, smoothed; None before the first good pose.
    """

    def __init__(self, arena: Arena, limits: VelocityLimits, may_be_carried: bool = True) -> None:
        """Start without a pose; a robot `may_be_carried` if its motion then proves which it is."""
        self.pose: Pose | None = None
        self.measured = -math.inf
        self.fault: PoseFault | None = None
        self.trouble = ''
        self.height: float | None = None
        self._arena = arena
        self._may_be_carried = may_be_carried
        self._clock = StampClock()
        self._reach = Reach(limits)
        self._arrivals: deque[float] = deque(maxlen=_REMEMBERED)
        self._place: object = None
        self._same_frames = 0
        self._z = 0.0
        self._bad_since = math.inf
        self._candidate: tuple[Pose, float] | None = None

    @property
    def rate(self) -> float:
        """Measurements per second, by the median gap; inf before there are three."""
        gaps = [later - earlier for earlier, later in itertools.pairwise(self._arrivals)]
        return 1.0 / max(statistics.median(gaps), 1e-6) if len(gaps) > 2 else math.inf

    def take(self, sample: Sample, now: float, paused: bool = False) -> bool:
        """Judge a measurement (Z-up) that arrived `now`; return whether it is good.

        While robots are paused a person may carry this one: where it rests, it is believed.
        """
        measured = now - self._clock.lateness(sample.stamp, now, paused)
        pose = sample.planar()
        self._arrivals.append(now)
        fault = fault_of(sample, self._arena) or self._fault_in_time(sample, pose, measured)
        if fault in (PoseFault.JUMPED, PoseFault.LIFTED) and self._has_settled(pose, now, paused):
            # The floor does not rise; but a person may have held the robot at its first pose.
            self._z = sample.position[2]
            self.height = self._z if self.height is None else min(self._z, self.height)
            self._reach.start(pose, measured)
            fault = PoseFault.LIFTED if self._is_lifted() else None
        if fault:
            self._reject(fault, sample, now)
            return False
        self._reach.add(pose, measured)
        self._note_height(sample.position[2], measured - self.measured)
        self.pose, self.measured = pose, measured
        self.fault, self.trouble, self._candidate = None, '', None
        self._bad_since = math.inf
        return True

    def _reject(self, fault: PoseFault, sample: Sample, now: float) -> None:
        self._bad_since = min(self._bad_since, now)
        if now - self._bad_since < _BAD_FOR_S:
            return
        self.fault, self.trouble = fault, text_of(fault, sample, self._arena)
        if fault is PoseFault.LIFTED:
            self.trouble = (
                f'it was lifted (body at {self._z:.2f} m, usually {self.height:.2f}): set it '
                'down; is y_up wrong in the lab file? If you moved its body, restart the '
                'experiment'
            )
        elif fault is PoseFault.JUMPED and not self._may_be_carried:
            self.trouble = (
                'it jumped (was it carried, or switched off and on, or were names swapped?): undo '
                'that, or restart the experiment'
            )

    def _fault_in_time(self, sample: Sample, pose: Pose, measured: float) -> PoseFault | None:
        place = sample.position, sample.orientation
        self._same_frames = self._same_frames + 1 if place == self._place else 1
        self._place = place
        if self._clock.repeats >= _SAME_FRAMES and self._same_frames == 1:
            return PoseFault.STAMPS
        if not self._reach.holds(pose, measured):
            return PoseFault.JUMPED
        self._z = sample.position[2]
        return PoseFault.LIFTED if self._is_lifted() else None

    def _is_lifted(self) -> bool:
        return self.height is not None and abs(self._z - self.height) > _LIFTED_M

    def _note_height(self, z: float, gap: float) -> None:
        """Follow the floor, slowly."""
        if self.height is None:
            self.height = z
        gap = min(max(gap, 0.0), 1.0)
        self.height += (1.0 - math.exp(-gap / _FLOOR_S)) * (z - self.height)

    def _has_settled(self, pose: Pose, now: float, paused: bool) -> bool:
        """Return whether a carried robot is at rest at its new place."""
        if not (paused and self._may_be_carried):
            self._candidate = None
            return False
        if self._candidate is None or not _near(self._candidate[0], pose):
            self._candidate = pose, now
        return now - self._candidate[1] >= _STEADY_S


def _near(one: Pose, other: Pose) -> bool:
    moved, turned = motion_between(one, other)
    return moved < _STEADY_M and turned < _STEADY_RAD
