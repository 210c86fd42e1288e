"""Decisions on this computer about a real robot: its command, or zero and why; a pure function.

Data that are missing, old, odd or contradictory mean zero. No decision depends on an earlier one.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Mapping
from dataclasses import dataclass

from setcmas_ctrl.pause_reason import PauseCause, PauseReason
from setcmas_expe.lab.lab import LOW_PERCENT, Lab
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.fleet.planar_pose import Pose
from setcmas_simu.fleet.topics import CMD_CART_VEL, robot_topic

RATE_HZ = 20.0
"""Rate of decisions and of commands to the robots, in Hz."""

HOLD_S = 0.3
"""Longest time for which a robot follows one command, in s: then its guard stops it."""

FROZEN_S = 0.4
"""Time in s after which equal poses of a robot that should move mean that it is lost."""

_LATE_SHARE = 0.5  # of the longest age, by stamps

Velocities = tuple[float, float]
"""Forward speed V in m/s and turn rate omega in rad/s."""

Direction = tuple[float, float]


class BridgeState(enum.Enum):
    """What a robot may do."""

    MOVING = 'moving'
    PAUSED = 'paused'
    STOPPED = 'stopped'


class Cause(enum.Enum):
    """Why a robot may not move as wanted; the values are texts for people."""

    UNSEEN = 'not seen yet'
    POSE_REJECTED = 'pose rejected'
    FROZEN = 'pose rejected: frozen'
    POSE_OLD = 'no good pose'
    POSE_LATE = 'poses come late'
    DEVIATES = 'it does not move as commanded'
    RIVAL = 'another node also commands it'
    PAST_GUARD = 'another node commands it past its guard'
    GUARD = 'its guard stops it'
    GUARD_SILENT = 'its guard is silent'
    DEAF = 'it does not follow its commands'
    IN_OBSTACLE = 'inside an obstacle of the lab; carry it out'
    OTHERS_UNSEEN = 'other robots have not been seen yet'
    NO_COMMAND = 'no command'
    NOT_A_NUMBER = (
        'its command is not a number; has its law failed, or do poses not reach its controller?'
    )
    OUTSIDE = 'outside the arena; it may only move back inside'
    TOO_NEAR = 'too near to another robot; it may only move away'

    @property
    def lasts(self) -> bool:
        """Whether the robot stays stopped until a person starts it again."""
        return self not in (Cause.OUTSIDE, Cause.TOO_NEAR)

    @property
    def is_blind(self) -> bool:
        """Whether it is unknown where the robot is."""
        poses = (Cause.POSE_REJECTED, Cause.FROZEN, Cause.POSE_OLD, Cause.POSE_LATE)
        return self in (Cause.UNSEEN, *poses, Cause.DEVIATES)

    @property
    def may_be_load(self) -> bool:
        """Whether an overloaded computer may be behind it: something is late or silent."""
        return self in (Cause.POSE_OLD, Cause.POSE_LATE, Cause.GUARD_SILENT, Cause.NO_COMMAND)

    @property
    def is_contest(self) -> bool:
        """Whether another node may drive the robot."""
        return self in (Cause.RIVAL, Cause.PAST_GUARD)


@dataclass(frozen=True)
class StopReason:
    """Why a robot may not move as wanted: the cause, and more about it for people."""

    cause: Cause
    details: str = ''

    @property
    def text(self) -> str:
        """The reason for people."""
        return self.details or self.cause.value


@dataclass(frozen=True)
class RobotView:
    """What the bridge of a robot knows of it; times in s on a steady clock, -inf before the first.

    Attributes:
        robot: Its number.
        pose: Its last good pose (m, rad); None before the first.
        measured: When it was measured, by arrival and stamp.
        received: When it came.
        same_since: When the first of the last poses came that are equal.
        velocities: By motion capture.
        pose_fault: Why its newest poses are rejected; empty if they are accepted.
        judged: When the mocap bridge last said whether they are.
        height: Height of its body in m; NaN if unknown.
        wanted: What its controller wants.
        commanded: When that came.
        rolled: When its wheel odometry came.
        trouble: Why the robot, its guard or its topics are not reliable; None if they are.
        charge: Of its battery in percent; NaN if unknown.
        driven_since: Since when it has been commanded to move; inf if it is not.
    """

    robot: int
    pose: Pose | None = None
    measured: float = -math.inf
    received: float = -math.inf
    same_since: float = math.inf
    velocities: Velocities = (0.0, 0.0)
    pose_fault: str = ''
    judged: float = -math.inf
    height: float = math.nan
    wanted: Velocities = (0.0, 0.0)
    commanded: float = -math.inf
    rolled: float = -math.inf
    trouble: StopReason | None = None
    charge: float = math.nan
    driven_since: float = math.inf


@dataclass(frozen=True)
class FleetView:
    """What each bridge must know of all robots, which are given by number.

    Attributes:
        pause: Why they are paused; None if they are not.
        robots: What the bridge of each knows.
        allowed: What each may drive of what is wanted.
        deviations: How the motion of some deviates from their commands.
    """

    pause: PauseReason | None
    robots: Mapping[int, RobotView]
    allowed: Mapping[int, Velocities]
    deviations: Mapping[int, str]


@dataclass(frozen=True)
class Decision:
    """The command of a robot, and the reason.

    Attributes:
        V: Forward speed in m/s.
        omega: Turn rate in rad/s.
        state: What it may do.
        why: Why it may not move as wanted; None if it may, or if only a pause keeps it.
        pause: Why it is paused; None if it is not.
    """

    V: float
    omega: float
    state: BridgeState
    why: StopReason | None = None
    pause: PauseReason | None = None

    @property
    def is_ready(self) -> bool:
        """Whether it moves, or only waits for the operator."""
        return self.pause is None or (self.pause.is_of_operator and self.why is None)

    @property
    def text(self) -> str:
        """The reasons for people; empty if it moves as wanted."""
        why = self.why.text if self.why else ''
        if self.pause is None:
            return why
        if not self.pause.is_of_operator:
            text = f'{BridgeState.PAUSED.value}: {self.pause.text}'
            says_all = self.pause.cause is PauseCause.LATCHED or not why
            return text if says_all else f'{text}; {why}'
        return f'{BridgeState.PAUSED.value}; {why}' if why else BridgeState.PAUSED.value


ZERO = Decision(0.0, 0.0, BridgeState.STOPPED)


def decide(robot: RobotView, fleet: FleetView, lab: Lab, now: float) -> Decision:
    """Return the command of a robot at a time in s."""
    # Who else drives the robot comes first: its motion then looks wrong, too.
    contest = robot.trouble if robot.trouble and robot.trouble.cause.is_contest else None
    why = contest or _blindness(robot, fleet, lab, now) or _unreadiness(robot, fleet, lab, now)
    if fleet.pause:
        # With other problems: a person is to see them before the start.
        return Decision(0.0, 0.0, BridgeState.PAUSED, why, fleet.pause)
    if why or robot.pose is None:
        return Decision(0.0, 0.0, BridgeState.STOPPED, why)
    V, omega = lab.limits.scaled_down(*fleet.allowed[robot.robot])
    outside = lab.arena.outward_normals(*robot.pose[:2])
    near = _robots_nearer(robot, fleet, lab.min_separation)
    forbidden: list[Direction | None] = [*outside]
    reasons = [Cause.OUTSIDE.value] if outside else []
    if near:
        forbidden += [_direction(robot.pose, pose) for pose in near.values()]
        robots = robots_in_words([*near])
        reasons.append(f'closer than {lab.min_separation:g} m to {robots}; it may only move away')
    if reasons:
        cause = Cause.OUTSIDE if outside else Cause.TOO_NEAR
        why = StopReason(cause, ' and '.join(reasons))
    if all(_recedes(robot.pose[2], V, omega, direction) for direction in forbidden):
        return Decision(V, omega, BridgeState.MOVING, why)
    # Turning on the spot is safe, and lets the robot face the way out.
    return Decision(0.0, omega, BridgeState.STOPPED, why)


def _robots_nearer(robot: RobotView, fleet: FleetView, distance: float) -> dict[int, Pose]:
    """Return the poses of robots whose centre is nearer than a distance (m), by number."""
    assert robot.pose
    return {
        number: other.pose
        for number, other in sorted(fleet.robots.items())
        if number != robot.robot
        and other.pose
        and math.dist(other.pose[:2], robot.pose[:2]) < distance
    }


def _blindness(robot: RobotView, fleet: FleetView, lab: Lab, now: float) -> StopReason | None:
    """Return why the robot's pose is unknown; None if it is known."""
    if robot.pose_fault:
        return StopReason(Cause.POSE_REJECTED, f'pose rejected: {robot.pose_fault}')
    if robot.pose is None:
        return StopReason(Cause.UNSEEN)
    # The decision holds for a period. A comparison with NaN is false: the pose is unknown then.
    longest_s = lab.timeouts.pose_s
    if not now - robot.measured + 1.0 / RATE_HZ <= longest_s:
        late = robot.received - robot.measured
        if late > _LATE_SHARE * longest_s:
            text = (
                f'poses come {late:.1f} s late by their stamps (a slow network, or a clock of '
                'motion capture that was changed: if a pause of 10 s does not help, and the '
                'network is fast, restart setcmas expe)'
            )
            return StopReason(Cause.POSE_LATE, text)
        return StopReason(Cause.POSE_OLD, f'no good pose for {longest_s:g} s')
    if not now - robot.judged <= longest_s:
        return StopReason(Cause.POSE_REJECTED, 'pose rejected: the mocap bridge is silent')
    same_for, driven_for = robot.received - robot.same_since, now - robot.driven_since
    if min(same_for, driven_for) >= FROZEN_S:
        return StopReason(Cause.FROZEN)
    if deviation := fleet.deviations.get(robot.robot):
        return StopReason(Cause.DEVIATES, f'pose rejected: {deviation}')
    return None


def _unreadiness(robot: RobotView, fleet: FleetView, lab: Lab, now: float) -> StopReason | None:
    """Return why a robot with a known pose may not move; None if it may."""
    if robot.trouble:
        low = f'; its battery was at {robot.charge:.0f} %' if robot.charge < LOW_PERCENT else ''
        return StopReason(robot.trouble.cause, f'{robot.trouble.text}{low}')
    if robot.pose and lab.obstacles.contain(*robot.pose[:2]):
        return StopReason(Cause.IN_OBSTACLE)
    if unseen := [number for number, other in fleet.robots.items() if other.pose is None]:
        text = f'{robots_in_words(unseen, "have")} not been seen yet'
        return StopReason(Cause.OTHERS_UNSEEN, text)
    if not now - robot.commanded <= lab.timeouts.command_s:
        topic = robot_topic(robot.robot, CMD_CART_VEL)
        text = f'no command for {lab.timeouts.command_s:g} s: does a law publish {topic}?'
        return StopReason(Cause.NO_COMMAND, text)
    is_number = all(map(math.isfinite, fleet.allowed[robot.robot]))
    return None if is_number else StopReason(Cause.NOT_A_NUMBER)


def _direction(pose: Pose, other: Pose) -> Direction | None:
    """Return the unit vector from a pose to another; None if they coincide."""
    dx, dy = other[0] - pose[0], other[1] - pose[1]
    distance = math.hypot(dx, dy)
    return (dx / distance, dy / distance) if distance > 0 else None


def _recedes(theta: float, V: float, omega: float, normal: Direction | None) -> bool:
    """Return whether a robot that follows its command for HOLD_S never moves along a normal.

    Its direction sweeps from theta to theta + omega HOLD_S. The directions away from the normal
    fill a half circle, which contains a sweep below pi if it contains both ends.
    """
    if V == 0.0:
        return True
    if normal is None or abs(omega) * HOLD_S >= math.pi:
        return False
    return all(
        V * (math.cos(angle) * normal[0] + math.sin(angle) * normal[1]) <= 0.0
        for angle in (theta, theta + omega * HOLD_S)
    )
