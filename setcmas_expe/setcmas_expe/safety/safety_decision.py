"""Decisions of the cmd_vel bridge about a real robot, as pure functions.

Whatever is missing, old, odd or contradictory means zero. Nothing here remembers anything, so a
decision depends only on what is known at its moment.
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
    """What a robot is let do."""

    MOVING = 'moving'
    """It moves, or is free to."""
    PAUSED = 'paused'
    STOPPED = 'stopped'


RATE_HZ = 20.0
"""Rate of decisions and of commands to the robots, in Hz."""

HOLD_S = 0.3
"""How long a robot may follow one command, in s: until its guard stops it."""

NOT_A_NUMBER = 'its command is not a number; has its law failed?'
IN_OBSTACLE = 'inside an obstacle of the lab; carry it out'
OUTSIDE = 'outside the arena; only motion back inside is let through'

Direction = tuple[float, float]


@dataclass(frozen=True)
class Situation:
    """What is known of one robot at a moment.

    Attributes:
        pose: Its last good pose (m, rad); None before the first.
        pose_age: Age of that pose in s.
        pose_fault: Why its newest poses are not believed; empty if they are.
        V: Forward speed that its controller wants, in m/s.
        omega: Turn rate that its controller wants, in rad/s.
        command_age: Age of that wish in s; inf before the first.
        paused: Why all robots are paused; empty if they are not.
        rival: Who else may move the robot, or move in its place; empty if nobody.
        fault: Why the robot cannot be relied upon; empty if it can.
        unseen: Robots that have not been seen since the start.
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
    """What a robot is commanded, and why.

    Attributes:
        V: Forward speed in m/s.
        omega: Turn rate in rad/s.
        state: What it is let do.
        reason: Why it is not free to move as wished; empty if it is.
        lost: Whether that is because nobody knows where it is.
        lasting: Whether it is to stand until a person starts it again.
    """

    V: float
    omega: float
    state: State
    reason: str
    lost: bool = False
    lasting: bool = False


def decide(situation: Situation, lab: Lab) -> Decision:
    """Return what a robot is commanded now."""
    held = _held(situation, lab)
    if held:
        return held
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
            f'nearer than {lab.min_separation:g} m to {robots_in_words(near)}; '
            'only motion apart is let through'
        )
        towards = [_direction(situation.pose, situation.others[other]) for other in near]
        allowed &= all(_recedes(situation.pose[2], V, omega, to) for to in towards)
    # Turning on the spot leaves the robot where it is, and lets it face the way out.
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


def _held(situation: Situation, lab: Lab) -> Decision | None:
    """Return the decision for a robot that must stand whatever it wants; None if there is none."""
    blind = _blindness(situation, lab.timeouts.pose_s)
    reason = blind or _unreadiness(situation, lab)
    if situation.paused:
        # What else is wrong is told too: whoever starts ought to know.
        reasons = [situation.paused]
        if reason and reason not in situation.paused and not reason.endswith(situation.paused):
            reasons.append(reason)
        return Decision(0.0, 0.0, State.PAUSED, '; '.join(reasons), bool(blind))
    if not reason:
        return None
    return Decision(0.0, 0.0, State.STOPPED, reason, lost=bool(blind), lasting=True)


def _unreadiness(situation: Situation, lab: Lab) -> str:
    """Return why a robot whose pose is known must stand; empty if it need not."""
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
    """Return why nobody knows where the robot is; empty if it is known."""
    if situation.pose is None:
        return 'not seen yet'
    if situation.pose_fault:
        return f'pose not believed: {situation.pose_fault}'
    # The decision holds for a period. A comparison with NaN is false: the pose is not known then.
    fresh = situation.pose_age + 1.0 / RATE_HZ <= timeout_s
    return '' if fresh else f'no good pose for {timeout_s:g} s'


def _direction(pose: Pose, other: Pose) -> Direction | None:
    """Return the unit vector from a pose to another; None if they are at one place."""
    dx, dy = other[0] - pose[0], other[1] - pose[1]
    distance = math.hypot(dx, dy)
    return (dx / distance, dy / distance) if distance > 0 else None


def _recedes(theta: float, V: float, omega: float, normal: Direction | None) -> bool:
    """Return whether a robot that holds its command for HOLD_S never moves along a normal.

    Its direction sweeps from theta to theta + omega HOLD_S. The directions that do not lead along
    the normal fill a half circle, which holds a sweep below pi if it holds both its ends.
    """
    if V == 0.0:
        return True
    if normal is None or abs(omega) * HOLD_S >= math.pi:
        return False
    return all(
        V * (math.cos(angle) * normal[0] + math.sin(angle) * normal[1]) <= 0.0
        for angle in (theta, theta + omega * HOLD_S)
    )
