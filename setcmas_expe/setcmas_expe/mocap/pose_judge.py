"""Judge of a robot's poses: which measurements of motion capture to trust; its velocities."""

from __future__ import annotations

import enum
import itertools
import math
import statistics
from collections import deque

from setcmas_expe.mocap.sources import Sample
from setcmas_simu.fleet.planar_pose import Pose, motion_between
from setcmas_simu.robots.arena import Arena
from setcmas_simu.robots.model import VelocityLimits
from setcmas_simu.robots.unicycle import velocities_between
from setcmas_simu.ros.stamp_clock import StampClock

TOO_SLOW_HZ = 4.0
"""Rate of measurements below which robots stop, in Hz: wrong ones are found too late then."""


class PoseFault(enum.Enum):
    """Why a measurement is rejected; the values are texts for people."""

    NOT_FINITE = 'not a number'
    ZERO = 'exactly zero'
    NO_ROTATION = 'orientation that is not a unit quaternion'
    TILTED = 'tilted (has the robot fallen over, or is y_up wrong in the lab file?)'
    FAR_AWAY = 'far outside the arena'
    JUMPED = 'it jumped (was it carried, or were names swapped? Pause for a second, then start)'
    LIFTED = 'it was lifted'
    STAMPS = 'its stamps do not change: correct the motion capture clock, or send no stamps'


_FAR_M = 1.0  # from the arena
_MILLIMETRES = 20.0  # m: a room is smaller
_NORM_TOLERANCE = 0.02
_LARGEST_TILT = math.radians(45)


def pose_fault(sample: Sample, arena: Arena) -> PoseFault | None:
    """Return the fault of a measurement on its own; None if it is good."""
    x, y, _ = sample.position
    if not all(map(math.isfinite, (*sample.position, *sample.orientation))):
        return PoseFault.NOT_FINITE
    if not any(sample.position):
        return PoseFault.ZERO
    if abs(math.hypot(*sample.orientation) - 1.0) > _NORM_TOLERANCE:
        return PoseFault.NO_ROTATION
    if _tilt(sample.orientation) > _LARGEST_TILT:
        return PoseFault.TILTED
    return PoseFault.FAR_AWAY if arena.distance(x, y) > _FAR_M else None


def fault_in_words(fault: PoseFault, sample: Sample, arena: Arena) -> str:
    """Return why a measurement is rejected, with numbers where they help."""
    if fault is not PoseFault.FAR_AWAY:
        return str(fault.value)
    x, y, _ = sample.position
    in_mm = arena.distance(x / 1000, y / 1000) == 0 and max(abs(x), abs(y)) > _MILLIMETRES
    hint = '; does motion capture send millimetres? It must send metres' if in_mm else ''
    return f'at x = {x:.1f} m, y = {y:.1f} m, {fault.value}{hint}'


def _tilt(orientation: tuple[float, float, float, float]) -> float:
    """Return the angle in rad between the body's z axis and the vertical."""
    qx, qy, qz, qw = orientation
    norm = qx * qx + qy * qy + qz * qz + qw * qw
    cosine = (qw * qw + qz * qz - qx * qx - qy * qy) / norm
    return math.acos(max(-1.0, min(1.0, cosine)))


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


class PoseJudge:
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
        fault = pose_fault(sample, self._arena) or self._fault_in_time(sample, pose, measured)
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
        self.fault, self.trouble = fault, fault_in_words(fault, sample, self._arena)
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


_TIME_CONSTANT_S = 0.1
_SHORTEST_STEP_S = 1e-3
_LONGEST_STEP_S = 1.0


class VelocityFilter:
    """Estimates forward speed and turn rate of one robot.

    Backward differences through a first-order low-pass filter, exact for any step (Astrom and
    Wittenmark, Computer-Controlled Systems, 1997, section 2.3).
    """

    def __init__(self) -> None:
        self._last: tuple[float, Pose] = -math.inf, (0.0, 0.0, 0.0)
        self._V = self._omega = 0.0

    def update(self, sample: Sample, now: float) -> tuple[float, float]:
        """Return speed (m/s) and turn rate (rad/s) at a measurement that arrived `now` (s)."""
        time, pose = sample.stamp or now, sample.planar()
        step = time - self._last[0]
        if 0.0 <= step < _SHORTEST_STEP_S:  # a repeated stamp
            return self._V, self._omega
        if 0.0 <= step <= _LONGEST_STEP_S:
            V, omega = map(float, velocities_between(self._last[1], pose, step))
            share = 1.0 - math.exp(-step / _TIME_CONSTANT_S)
            self._V += share * (V - self._V)
            self._omega += share * (omega - self._omega)
        else:  # a gap, or a clock that was set
            self._V = self._omega = 0.0
        self._last = time, pose
        return self._V, self._omega
