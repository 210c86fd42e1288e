"""Pose track of one robot: which measurements of motion capture to trust."""

from __future__ import annotations

import itertools
import math
import statistics
from collections import Counter, deque

from setcmas_expe.mocap.sample import Pose, Sample, fault_of
from setcmas_simu.fleet.planar_pose import wrap_angle
from setcmas_simu.robots.arena import Arena
from setcmas_simu.robots.model import VelocityLimits

_DRIFT = 1e-3
"""Largest drift between two clocks, in s per s."""


class StampClock:
    """Estimates delays from stamps of another machine's clock.

    The smallest difference between arrival and stamp so far counts as no delay. Stamps that go
    backwards mean that the clock was set: delay cannot reverse their order.
    """

    def __init__(self) -> None:
        self._offset: float | None = None
        self._stamp = self._now = 0.0
        self.repeats = 0
        """Number of measurements in a row that repeated the stamp before."""

    def lateness(self, stamp: float, now: float) -> float:
        """Return the delay of a measurement in s, compared with the smallest so far.

        Its stamp is on the sender's clock, 0 if not set (no delay then); it arrived `now` on a
        steady clock.
        """
        self.repeats = self.repeats + 1 if stamp == self._stamp != 0.0 else 0
        if stamp == 0.0:
            return 0.0
        offset = now - stamp
        if self._offset is None or stamp < self._stamp:
            self._offset = offset
        self._offset = min(offset, self._offset + _DRIFT * max(0.0, now - self._now))
        self._stamp, self._now = stamp, now
        return offset - self._offset


SLOWEST_HZ = 10.0
"""Rate of measurements below which users are warned, in Hz."""

_LONGEST_GAP_S = 0.25  # two longer gaps in a row are too slow to steer
_REMEMBERED = 20


class Arrivals:
    """Times of the last measurements, in s on a steady clock."""

    def __init__(self) -> None:
        self._times: deque[float] = deque(maxlen=_REMEMBERED)

    def add(self, now: float) -> float:
        """Note a measurement; return the gap before it in s, 0 at first."""
        gap = now - self._times[-1] if self._times else 0.0
        self._times.append(now)
        return gap

    @property
    def rate(self) -> float:
        """Measurements per second, by the median gap; inf before there are three."""
        gaps = self._gaps()
        return 1.0 / max(statistics.median(gaps), 1e-6) if len(gaps) > 2 else math.inf

    @property
    def gap(self) -> float:
        """The shorter of the last two gaps in s (the network may cause one); 0 before."""
        gaps = self._gaps()[-2:]
        return min(gaps) if len(gaps) == 2 else 0.0

    @property
    def are_slow(self) -> bool:
        """Whether the last two gaps were too long."""
        return self.gap > _LONGEST_GAP_S

    def _gaps(self) -> list[float]:
        return [later - earlier for earlier, later in itertools.pairwise(self._times)]


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

    def of(self, seconds: float) -> float:
        """Return how far in m the robot can have moved in a time."""
        step = min(max(0.0, seconds), _BLIND_S) + _LATE_S
        return _FASTER * self._limits.V_max * step + _NOISE_M

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
        return all(self._near(*one, pose, measured) for one in ends)

    def _near(self, then: float, old: Pose, pose: Pose, measured: float) -> bool:
        seconds = measured - then
        turned = abs(float(wrap_angle(pose[2] - old[2])))
        turn = self._limits.omega_max * (min(max(0.0, seconds), _BLIND_S) + _LATE_S)
        return (
            math.hypot(pose[0] - old[0], pose[1] - old[1]) <= self.of(seconds)
            and turned <= _FASTER * turn + _NOISE_RAD
        )


JUMPED = 'jumped'
FROZEN = 'frozen'
LIFTED = 'lifted'
SLOW = 'slow'
STAMPS = 'constant stamps'

_JUMPED_TROUBLE = 'it jumped (if you carried it: pause for a second, then start)'

_FROZEN_S = 0.4  # after which equal poses of a robot that should move mean that it is lost
_LIFTED_M = 0.05  # from the usual height: the robot is off the floor
_FROZEN_FRAMES = 4
_FLOOR_S = 10.0  # time constant of the usual height: floors slope, calibrations too
_BAD_FOR_S = 0.1  # single bad frames are ignored
_STEADY_S = 1.0
_STEADY_M = 0.03
_STEADY_RAD = 0.2


class PoseTrack:
    """Judges measurements one by one; all times in s on one steady clock.

    Attributes:
        pose: The last good pose (x, y in m, heading in rad); None before the first.
        received: When it arrived; -inf before the first.
        fault: Why poses are rejected now; empty if they are not.
        rejected: Number of rejected measurements by reason, until a reader clears it.
        jumped_to: Newest measurement if it is too far from the last good pose; None if not.
        arrivals: Times of all measurements, good and bad.
        height: Height of its body in m, smoothed; None before the first good pose.
        swapped_with: Number of the robot whose place this robot seems to have taken, if any.
    """

    def __init__(self, arena: Arena, limits: VelocityLimits) -> None:
        self.pose: Pose | None = None
        self.received = -math.inf
        self.fault = ''
        self.rejected: Counter[str] = Counter()
        self.jumped_to: Pose | None = None
        self.swapped_with: int | None = None
        self._arena = arena
        self._clock = StampClock()
        self._lateness = 0.0
        self._paused = True
        self._moving_since = math.inf
        self._reach = Reach(limits)
        self.arrivals = Arrivals()
        self.height: float | None = None
        self._z = 0.0
        self._last: tuple[object, object] | None = None
        self._same_since = math.inf
        self._same_frames = 0
        self._frozen = False
        self._bad_since = math.inf
        self._candidate: tuple[Pose, float] | None = None

    @property
    def trouble(self) -> str:
        """Why poses are rejected now, for messages; empty if they are not."""
        if self.swapped_with is not None:
            return f'it seems to have swapped places with robot {self.swapped_with}'
        if self.fault == LIFTED:
            return (
                f'it was lifted (body at {self._z:.2f} m, usually {self.height:.2f}): set it '
                'down; is y_up wrong in the lab file? If you moved its body, restart the '
                'experiment'
            )
        if self.fault == STAMPS:
            return 'its stamps do not change: correct the motion capture clock, or send no stamps'
        if self.fault == SLOW:
            return (
                f'two gaps of {self.arrivals.gap:.2f} s or more in a row (limit '
                f'{_LONGEST_GAP_S:g} s): check the network and the rate of motion capture'
            )
        return _JUMPED_TROUBLE if self.fault == JUMPED else self.fault

    @property
    def repeats(self) -> bool:
        """Whether the newest measurements are equal."""
        return self._same_frames >= _FROZEN_FRAMES

    def age(self, now: float) -> float:
        """Return the age of the last good pose in s; inf before the first."""
        return now - self.received + self._lateness

    def note_command(self, moving: bool, paused: bool, now: float) -> None:
        """Note whether the robot is commanded to move now, and whether all are paused."""
        self._moving_since = min(self._moving_since, now) if moving else math.inf
        self._paused = paused

    def take(self, sample: Sample, now: float) -> bool:
        """Judge a measurement (Z-up); return whether it is good."""
        lateness = self._clock.lateness(sample.stamp, now)
        pose = sample.planar()
        gap = self.arrivals.add(now)
        fault = fault_of(sample, self._arena) or self._fault_in_time(sample, pose, now, lateness)
        if fault in (JUMPED, LIFTED) and self._has_settled(pose, now):
            # The floor does not rise; but a person may have held the robot at its first pose.
            self._z = sample.position[2]
            self.height = self._z if self.height is None else min(self._z, self.height)
            self._reach.start(pose, now - lateness)
            fault = LIFTED if self._is_lifted() else None
        if fault:
            self._reject(fault, pose, now)
            return False
        self.pose, self.received, self._lateness = pose, now, lateness
        self._reach.add(pose, now - lateness)
        self._note_height(sample.position[2], gap)
        self.fault = ''
        self.jumped_to = self.swapped_with = self._candidate = None
        self._bad_since = math.inf
        return True

    def _reject(self, fault: str, pose: Pose, now: float) -> None:
        self.rejected[fault] += 1
        self.jumped_to = pose if fault == JUMPED else None
        self._bad_since = min(self._bad_since, now)
        # A pose counts as frozen only after a while.
        if now - self._bad_since >= _BAD_FOR_S or fault == FROZEN:
            self.fault = fault
        if self.swapped_with is not None and fault != JUMPED:
            self.swapped_with = None

    def _fault_in_time(
        self, sample: Sample, pose: Pose, now: float, lateness: float
    ) -> str | None:
        if self._is_frozen(sample, now):
            return FROZEN
        if self._clock.repeats >= _FROZEN_FRAMES and self._same_frames == 1:
            return STAMPS
        if not self._reach.holds(pose, now - lateness):
            return JUMPED
        self._z = sample.position[2]
        if self._is_lifted():
            return LIFTED
        return SLOW if self.arrivals.are_slow else None

    def _is_lifted(self) -> bool:
        return self.height is not None and abs(self._z - self.height) > _LIFTED_M

    def _note_height(self, z: float, gap: float) -> None:
        """Follow the floor, slowly."""
        if self.height is None:
            self.height = z
        self.height += (1.0 - math.exp(-min(gap, 1.0) / _FLOOR_S)) * (z - self.height)

    def _is_frozen(self, sample: Sample, now: float) -> bool:
        place = sample.position, sample.orientation
        if place != self._last:
            self._last, self._same_since, self._same_frames = place, now, 0
            self._frozen = False
        self._same_frames += 1
        if self._paused:  # the operator has looked
            self._frozen = False
        since = max(self._same_since, self._moving_since)
        if now - since >= _FROZEN_S and self._same_frames >= _FROZEN_FRAMES:
            self._frozen = True  # as long as poses are equal, although the robot now stops
        return self._frozen

    def _has_settled(self, pose: Pose, now: float) -> bool:
        """Return whether a carried robot is at rest at its new place."""
        if not self._paused or self.swapped_with is not None:
            self._candidate = None
            return False
        if self._candidate is None or not _near(self._candidate[0], pose):
            self._candidate = pose, now
        return now - self._candidate[1] >= _STEADY_S


def _near(one: Pose, other: Pose) -> bool:
    moved = math.hypot(one[0] - other[0], one[1] - other[1])
    return moved < _STEADY_M and abs(float(wrap_angle(one[2] - other[2]))) < _STEADY_RAD


def mark_swapped(tracks: dict[int, PoseTrack]) -> list[int]:
    """Mark robots that jumped to each other's places, in a circle; return those newly marked."""
    jumped = {robot: track for robot, track in tracks.items() if track.jumped_to}
    taken = {
        robot: other
        for robot, track in jumped.items()
        for other, previous in jumped.items()
        if robot != other and _took_place(track, previous)
    }
    swapped = [robot for robot in taken if _is_in_circle(robot, taken)]
    new = [robot for robot in swapped if jumped[robot].swapped_with is None]
    for robot in new:
        jumped[robot].swapped_with = taken[robot]
    return new


def _is_in_circle(robot: int, taken: dict[int, int]) -> bool:
    current: int | None = robot
    for _ in taken:
        current = taken.get(current) if current is not None else None
        if current == robot:
            return True
    return False


def _took_place(track: PoseTrack, other: PoseTrack) -> bool:
    assert track.jumped_to is not None
    assert other.pose is not None
    x, y, _ = track.jumped_to
    reach = track._reach.of(math.inf) + 2 * _NOISE_M
    return math.hypot(x - other.pose[0], y - other.pose[1]) <= reach
