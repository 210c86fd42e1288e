"""Nudge of each robot, one after the other: which body moves, and which way."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

from rclpy.publisher import Publisher
from std_msgs.msg import Bool

from setcmas_expe.doctor.findings import OK, PROBLEM, Finding
from setcmas_expe.doctor.lab_watch import LabWatch
from setcmas_expe.lab.lab import Lab, LabRobot
from setcmas_expe.mocap.sample import Pose
from setcmas_simu.cmd_vel.cmd_vel_publisher import CmdVelPublisher
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.planar_pose import wrap_angle
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.ros import qos
from setcmas_simu.ros.process import RosProcess

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


_PERIOD_S = 0.05
_SETTLING_S = 0.4
_ROLLS = 0.01  # m/s
_LAST_ZEROS = 5
_PAUSE_S = 1.0  # the publisher is new, and guards have to discover it
_REFUSED = 'no nudge'
_UNGUARDED = 'without it the robot keeps going when this machine or the network dies'


class Nudger:
    """Moves one robot at a time; every other one must stand."""

    def __init__(self, process: RosProcess, watch: LabWatch) -> None:
        """Prepare; nothing moves before `findings`."""
        self._process = process
        self._watch = watch
        self._lab = watch.lab

    @cached_property
    def _paused(self) -> Publisher:
        # A guard follows whoever commands its robot only after it was told to pause, and then go.
        # Not made before it is known that nobody else pauses robots: a second one pauses them all.
        return self._watch.create_publisher(Bool, topics.PAUSED, qos.STATE)

    def findings(self) -> Iterator[Finding]:
        """Nudge each robot that may be, and tell what that proves."""
        for robot in self._lab.robots:
            if self._process.stopping:
                return
            refusal = self._refusal(robot)
            if refusal:
                what = f'nudge of {robot_name(robot.number)}'
                yield Finding(PROBLEM, what, f'{_REFUSED}: {refusal[0]}', refusal[1])
            else:
                yield from self._nudge(robot)

    def _refusal(self, robot: LabRobot) -> tuple[str, str] | None:
        """Return why a robot must not be nudged and what to do; None if it may be."""
        if self._watch.runs_experiment():
            return 'an experiment is running', 'end the experiment (q in its terminal) first'
        if rival := self._watch.rival(robot):
            return rival, 'stop it first'
        self._watch.take_guards()
        if not self._watch.robot_guards[robot.number].is_there():
            return 'no cmd_vel_guard on it', 'install it on the robot (docs/lab.md): ' + _UNGUARDED
        poses = self._watch.poses()
        unseen = [r for r in self._watch.robots if r not in poses or self._is_lost(r)]
        if unseen:
            names = ', '.join(map(robot_name, unseen))
            return f'{names} not seen', 'motion capture must see every robot of the lab'
        if source_conflict := next(
            filter(None, map(self._watch.source_conflict, self._watch.robots)), ''
        ):
            return source_conflict, 'end the other sender: nobody knows which poses are true'
        why = obstacle(robot.number, poses, self._lab)
        return (why, 'put it where it has 20 cm to all sides') if why else None

    def _is_lost(self, robot: int) -> bool:
        return self._watch.pose_age(robot) > self._lab.timeouts.pose_s

    def _nudge(self, robot: LabRobot) -> Iterator[Finding]:
        commands = CmdVelPublisher(
            self._watch,
            robot.number,
            robot.topic(topics.CMD_VEL),
            robot.topic(topics.ODOM),
            self._lab.cmd_vel_type,
            qos.ROBOT_COMMAND,
        )
        try:
            self._process.spin_until(commands.follow_listeners, 1.0)
            self._pause(commands, _PAUSE_S)
            start = self._watch.poses()
            delay = self._drive(commands, FORWARD, robot)
            forward = self._watch.poses()
            self._drive(commands, BACK, robot)
            back = self._watch.poses()
            self._drive(commands, LEFT, robot)
            left = self._watch.poses()
            self._drive(commands, RIGHT, robot)
        except _BrokenOff as reason:
            what = f'nudge of {robot_name(robot.number)}'
            yield Finding(
                PROBLEM,
                what,
                f'broken off: {reason}',
                'see that its way is free, and that nobody else commands it',
            )
            return
        finally:
            self._pause(commands, _LAST_ZEROS * _PERIOD_S)  # several, in case one is lost
            commands.wait_until_sent()
        yield forward_finding(robot.number, start, forward)
        yield turn_finding(robot.number, back[robot.number], left[robot.number])
        if delay is not None:
            what = f'delay of {robot_name(robot.number)}'
            yield Finding(OK, what, f'{1e3 * delay:.0f} ms from command to turning wheels')

    def _drive(self, commands: CmdVelPublisher, phase: Phase, robot: LabRobot) -> float | None:
        """Drive for one phase; returns the time in s until the wheels turned, None if unseen.

        Raises:
            _BrokenOff: Something is not as it should be.
        """
        start = self._watch.poses()
        begin = time.monotonic()
        delay = None
        while (elapsed := time.monotonic() - begin) < phase.duration:
            self._paused.publish(Bool(data=False))
            commands.publish(phase.V, phase.omega)
            self._process.spin_until(lambda: False, min(_PERIOD_S, phase.duration - elapsed))
            self._watch_over(start)
            if trouble := self._watch.rival(robot) or self._watch.source_conflict(robot.number):
                raise _BrokenOff(trouble)
            speed = self._watch.robots[robot.number].wheel_speed
            if delay is None and speed and speed[1] > begin and abs(speed[0]) > _ROLLS:
                delay = speed[1] - begin
        stop = time.monotonic()
        while time.monotonic() - stop < _SETTLING_S:
            self._paused.publish(Bool(data=False))
            commands.publish(0.0, 0.0)
            self._process.spin_until(lambda: False, _PERIOD_S)
        self._watch_over(start)
        return delay

    def _pause(self, commands: CmdVelPublisher, seconds: float) -> None:
        """Command zero, and say so, for a while."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._paused.publish(Bool(data=True))
            commands.publish(0.0, 0.0)
            time.sleep(_PERIOD_S)

    def _watch_over(self, start: dict[int, Pose]) -> None:
        """See that all is well.

        Raises:
            _BrokenOff: It is not.
        """
        if self._process.stopping:
            raise _BrokenOff('stopped by the user')
        poses = self._watch.poses()
        for robot, (x, y, _) in start.items():
            if robot not in poses or self._is_lost(robot):
                raise _BrokenOff(f'motion capture lost {robot_name(robot)}')
            if math.hypot(poses[robot][0] - x, poses[robot][1] - y) > TOO_FAR_M:
                raise _BrokenOff(f'{robot_name(robot)} moved further than it should')


class _BrokenOff(Exception):  # noqa: N818, it ends a nudge and is no mistake of the program
    """Why a nudge was broken off."""
