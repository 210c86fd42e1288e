"""Decisions of the cmd_vel bridge about a real robot, as pure functions.

Data that are missing, old, odd or contradictory mean zero. No decision depends on an earlier one.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Mapping
from dataclasses import dataclass

from setcmas_expe.lab.lab import Lab
from setcmas_expe.mocap.sample import Pose
from setcmas_simu.fleet.fleet import robots_in_words


class State(enum.Enum):
    """What a robot may do."""

    MOVING = 'moving'
    PAUSED = 'paused'
    STOPPED = 'stopped'


RATE_HZ = 20.0
"""Rate of decisions and of commands to the robots, in Hz."""

HOLD_S = 0.3
"""Longest time for which a robot follows one command, in s: then its guard stops it."""

NOT_A_NUMBER = 'its command is not a number; has its law failed?'
IN_OBSTACLE = 'inside an obstacle of the lab; carry it out'
OUTSIDE = 'outside the arena; it may only move back inside'

Direction = tuple[float, float]


@dataclass(frozen=True)
class Situation:
    """What the bridge knows of one robot at a moment.

    Attributes:
        pose: Its last good pose (m, rad); None before the first.
        pose_age: Age of that pose in s.
        pose_fault: Why its newest poses are rejected; empty if they are accepted.
        V: Forward speed that its controller wants, in m/s.
        omega: Turn rate that its controller wants, in rad/s.
        command_age: Age of that command in s; inf before the first.
        paused: Why all robots are paused; empty if they are not.
        rival: Another process that may move the robot or play it; empty if none.
        fault: Why the robot is not reliable; empty if it is.
        unseen: Robots that motion capture has not seen yet.
        others: Last good poses of the other robots, by number.
    """

    pose: Pose | None
    pose_age: float
    pose_fault: str
    V: float
    omega: float
    command_age: float
    paused: str
    rival: str
    fault: str
    unseen: tuple[int, ...]
    others: Mapping[int, Pose]


@dataclass(frozen=True)
class Decision:
    """The command of a robot, and the reason.

    Attributes:
        V: Forward speed in m/s.
        omega: Turn rate in rad/s.
        state: What it may do.
        reason: Why it may not move as wanted; empty if it may.
        lost: Whether the reason is that its pose is unknown.
        lasting: Whether it must stay stopped until a person starts it again.
    """

    V: float
    omega: float
    state: State
    reason: str
    lost: bool = False
    lasting: bool = False


def decide(situation: Situation, lab: Lab) -> Decision:
    """Return the command of a robot now."""
    stop = _stop(situation, lab)
    if stop:
        return stop
    assert situation.pose is not None
    V, omega = lab.limits.scaled_down(situation.V, situation.omega)
    reasons = []
    allowed = True
    outward = lab.arena.outward_normals(*situation.pose[:2])
    if outward:
        reasons.append(OUTSIDE)
        allowed = all(_recedes(situation.pose[2], V, omega, normal) for normal in outward)
    near = robots_nearer(situation.pose, situation.others, lab.min_separation)
    if near:
        reasons.append(
            f'closer than {lab.min_separation:g} m to {robots_in_words(near)}; '
            'it may only move away'
        )
        towards = [_direction(situation.pose, situation.others[other]) for other in near]
        allowed &= all(_recedes(situation.pose[2], V, omega, to) for to in towards)
    # Turning on the spot is safe, and lets the robot face the way out.
    return Decision(
        V if allowed else 0.0,
        omega,
        State.MOVING if allowed else State.STOPPED,
        ' and '.join(reasons),
    )


def robots_nearer(pose: Pose, others: Mapping[int, Pose], distance: float) -> list[int]:
    """Return the robots whose centre is nearer than a distance (m) to a pose, sorted."""
    return sorted(
        number
        for number, (x, y, _) in others.items()
        if math.hypot(x - pose[0], y - pose[1]) < distance
    )


def _stop(situation: Situation, lab: Lab) -> Decision | None:
    """Return the decision that stops a robot; None if it may move."""
    blind = _blindness(situation, lab.timeouts.pose_s)
    reason = blind or _unreadiness(situation, lab)
    if situation.paused:
        # Report other problems too, before a person starts the robots.
        reasons = [situation.paused]
        if reason and reason not in situation.paused and not reason.endswith(situation.paused):
            reasons.append(reason)
        return Decision(0.0, 0.0, State.PAUSED, '; '.join(reasons), bool(blind))
    if not reason:
        return None
    return Decision(0.0, 0.0, State.STOPPED, reason, lost=bool(blind), lasting=True)


def _unreadiness(situation: Situation, lab: Lab) -> str:
    """Return why a robot with a known pose may not move; empty if it may."""
    if situation.rival:
        return situation.rival
    if situation.fault:
        return situation.fault
    if situation.pose and lab.obstacles.contain(*situation.pose[:2]):
        return IN_OBSTACLE
    if situation.unseen:
        return f'{robots_in_words(list(situation.unseen), "have")} not been seen yet'
    if not situation.command_age <= lab.timeouts.command_s:
        return f'no command for {lab.timeouts.command_s:g} s'
    finite = math.isfinite(situation.V) and math.isfinite(situation.omega)
    return '' if finite else NOT_A_NUMBER


def _blindness(situation: Situation, timeout_s: float) -> str:
    """Return why the robot's pose is unknown; empty if it is known."""
    if situation.pose is None:
        return 'not seen yet'
    if situation.pose_fault:
        return f'pose rejected: {situation.pose_fault}'
    # The decision holds for a period. A comparison with NaN is false: the pose is unknown then.
    fresh = situation.pose_age + 1.0 / RATE_HZ <= timeout_s
    return '' if fresh else f'no good pose for {timeout_s:g} s'


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
