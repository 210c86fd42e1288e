"""Nudge of a robot: a short way forward and a small turn, and what they prove."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from setcmas_expe.doctor.findings import OK, PROBLEM, Finding
from setcmas_expe.lab.model import Lab
from setcmas_expe.mocap.sample import Pose
from setcmas_simu.fleet.planar_pose import wrap_angle
from setcmas_simu.fleet.topics import robot_name

SPEED = 0.05
"""Forward speed of the nudge, in m/s: it lasts a second, so the way is 5 cm."""

TURN_RATE = 0.5
"""Turn rate of the nudge, in rad/s."""

TOO_FAR_M = 0.10
"""Motion of any robot from which a nudge is broken off, in m."""

_MOVED_M = 0.02
_HEADING_TOLERANCE = math.radians(30)
_TURNED_RAD = 0.08


@dataclass(frozen=True)
class Phase:
    """A part of the nudge.

    Attributes:
        V: Forward speed in m/s.
        omega: Turn rate in rad/s.
        duration: In s.
    """

    V: float
    omega: float
    duration: float


FORWARD = Phase(SPEED, 0.0, 1.0)
BACK = Phase(-SPEED, 0.0, 1.0)
LEFT = Phase(0.0, TURN_RATE, 0.5)
RIGHT = Phase(0.0, -TURN_RATE, 0.5)


def obstacle(robot: int, poses: Mapping[int, Pose], lab: Lab) -> str:
    """Return why a robot has no room for a nudge; empty if it has.

    Args:
        robot: The robot.
        poses: Poses of all robots (m, rad), by number.
        lab: Arena and smallest separation. Which way the robot faces is what the nudge is to
            find out, so there must be room on all sides.
    """
    x, y, _ = poses[robot]
    way = SPEED * FORWARD.duration + _MOVED_M
    corners = [(x + dx, y + dy) for dx in (-way, way) for dy in (-way, way)]
    if any(lab.arena.distance(*corner) > 0 for corner in corners):
        return 'it stands too near to the border of the arena'
    for other, (ox, oy, _) in poses.items():
        if other != robot and math.hypot(ox - x, oy - y) < lab.min_separation + way:
            return f'it stands too near to {robot_name(other)}'
    return ''


def moved_robots(before: Mapping[int, Pose], after: Mapping[int, Pose]) -> list[int]:
    """Return the robots that have moved by more than 2 cm."""
    return [
        robot
        for robot, (x, y, _) in before.items()
        if math.hypot(after[robot][0] - x, after[robot][1] - y) > _MOVED_M
    ]


def forward_finding(robot: int, before: Mapping[int, Pose], after: Mapping[int, Pose]) -> Finding:
    """Return what the way forward of a robot proves.

    Args:
        robot: The robot that was told to go forward.
        before: Poses of all robots before (m, rad), by number.
        after: And after.
    """
    what = f'nudge of {robot_name(robot)}'
    moved = moved_robots(before, after)
    if not moved:
        advice = (
            'no rigid body moved: are its motors on (motor_power), does it stand on its wheels, '
            'and does motion capture track it?'
        )
        return Finding(PROBLEM, what, 'it does not move', advice)
    if moved != [robot]:
        others = ', '.join(map(robot_name, moved))
        advice = (
            'the rigid bodies have the wrong names: exchange mocap_name or namespace in the lab '
            'file, or rename the bodies in the motion capture system'
        )
        return Finding(PROBLEM, what, f'{others} moved instead', advice)
    dx, dy = after[robot][0] - before[robot][0], after[robot][1] - before[robot][1]
    off = float(wrap_angle(math.atan2(dy, dx) - before[robot][2]))
    centimetres = f'{100 * math.hypot(dx, dy):.1f} cm'
    if abs(off) <= _HEADING_TOLERANCE:
        return Finding(OK, what, f'{centimetres} forward, {round(math.degrees(off)):+d} deg off')
    if math.pi - abs(off) <= _HEADING_TOLERANCE:
        return Finding(
            PROBLEM,
            what,
            f'{centimetres} backward by its heading',
            'its heading is reversed: turn the x axis of its rigid body to the front',
        )
    return Finding(
        PROBLEM,
        what,
        f'{centimetres}, {round(math.degrees(off)):+d} deg beside its heading',
        'set the heading of its rigid body to 0 while it faces along the x axis (or y_up in the '
        'lab file is wrong)',
    )


def turn_finding(robot: int, before: Pose, after: Pose) -> Finding:
    """Return what a turn to the left proves, from the poses (m, rad) before and after."""
    what = f'turn of {robot_name(robot)}'
    turned = float(wrap_angle(after[2] - before[2]))
    found = f'{round(math.degrees(turned)):+d} deg to the left'
    if turned >= _TURNED_RAD:
        return Finding(OK, what, found)
    if turned <= -_TURNED_RAD:
        advice = (
            'its heading has the wrong sign: see y_up in the lab file, and the axes of the body'
        )
        return Finding(PROBLEM, what, found, advice)
    return Finding(PROBLEM, what, found, 'its heading does not follow: is its body asymmetric?')
