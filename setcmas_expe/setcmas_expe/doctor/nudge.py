"""Nudge of each robot in turn: drive it a few centimetres, and prove which body it carries.

The proof is that of an experiment (safety/motion_watch.py): motion capture must see each robot
move as commanded while the others are at rest.
"""

from __future__ import annotations

import cmath
import math
import time
from collections.abc import Iterator, Mapping
from functools import cached_property

from rclpy.publisher import Publisher
from std_msgs.msg import Bool

from setcmas_expe.doctor.findings import OK, PROBLEM, Finding
from setcmas_expe.doctor.lab_watch import LabWatch
from setcmas_expe.lab.lab import Lab, LabRobot
from setcmas_expe.mocap.sample import Pose
from setcmas_expe.safety.body_identity import CRAWL_M_S, PROOF_M
from setcmas_expe.safety.motion_watch import MotionWatch
from setcmas_expe.safety.robot_bridges import robot_commands
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.planar_pose import wrap_angle
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.ros import qos
from setcmas_simu.ros.cmd_vel_topics import CmdVelPublisher
from setcmas_simu.ros.process import RosProcess

_TURN_RATE = 0.5  # rad/s
_FORWARD_S = _TURN_S = 1.0
_STILL_S = 0.3  # until guards trust the start
_SETTLING_S = 0.4
_PAUSE_S = 1.0  # guards have to discover the new publisher
_LAST_PAUSE_S = 0.25  # several zeros, in case one is lost
_PERIOD_S = 0.05
_ROOM_M = 0.02
_TOO_FAR_M = 0.10
_UNGUARDED = 'without it the robot keeps going when this machine or the network dies'


def missing_room(robot: int, poses: Mapping[int, Pose], lab: Lab) -> str:
    """Return why a robot has no room for a nudge on all sides; empty if it has.

    Args:
        robot: Its number.
        poses: Poses (m, rad) of all robots; the heading is not proved yet.
        lab: The lab.
    """
    x, y, _ = poses[robot]
    way = CRAWL_M_S * _FORWARD_S + _ROOM_M
    corners = [(x + dx, y + dy) for dx in (-way, way) for dy in (-way, way)]
    if any(lab.arena.distance(*corner) > 0 for corner in corners):
        return 'it is too close to the border of the arena'
    for other, (ox, oy, _) in poses.items():
        if other != robot and math.hypot(ox - x, oy - y) < lab.min_separation + way:
            return f'it is too close to {robot_name(other)}'
    return ''


class Nudger:
    """Moves one robot at a time; all others must be at rest."""

    def __init__(self, process: RosProcess, watch: LabWatch) -> None:
        """Prepare; nothing moves before `findings`."""
        self._process = process
        self._watch = watch
        self._lab = watch.lab
        self._motion = MotionWatch(watch.robots, lambda _: None, lambda _: None)

    @cached_property
    def _paused(self) -> Publisher:
        # A guard follows a new commander only after a pause and a start. Created late: a second
        # publisher would pause the robots of a running experiment.
        return self._watch.create_publisher(Bool, topics.PAUSED, qos.STATE)

    def findings(self) -> Iterator[Finding]:
        """Nudge each robot unless there is a reason not to; yield the results."""
        for robot in self._lab.robots:
            if self._process.stopping:
                return
            if refusal := self._refusal(robot):
                found, advice = refusal
                what = f'nudge of {robot_name(robot.number)}'
                yield Finding(PROBLEM, what, f'no nudge: {found}', advice)
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
            return 'no cmd_vel_guard on it', f'install it (docs/lab_setup.md): {_UNGUARDED}'
        poses = self._watch.poses()
        unseen = [r for r in self._watch.robots if r not in poses or self._is_lost(r)]
        if unseen:
            names = ', '.join(map(robot_name, unseen))
            return f'{names} not seen', 'motion capture must see every robot of the lab'
        conflicts = map(self._watch.source_conflict, self._watch.robots)
        if conflict := next(filter(None, conflicts), ''):
            return conflict, 'end the other sender: the poses of two senders cannot be trusted'
        why = missing_room(robot.number, poses, self._lab)
        return (why, 'put it where it has 20 cm to all sides') if why else None

    def _is_lost(self, robot: int) -> bool:
        return self._watch.pose_age(robot) > self._lab.timeouts.pose_s

    def _nudge(self, robot: LabRobot) -> list[Finding]:
        commands = robot_commands(self._watch, robot, self._lab)
        findings = []
        name = robot_name(robot.number)
        try:
            self._process.spin_until(commands.follow_listeners, 1.0)
            self._pause(commands, _PAUSE_S)
            for part, go in (('nudge', self._go), ('turn', self._turn)):
                findings.append(Finding(OK, f'{part} of {name}', go(commands, robot)))
        except _AbortedError as reason:
            findings.append(Finding(PROBLEM, f'{part} of {name}', str(reason), reason.advice))
        finally:
            self._pause(commands, _LAST_PAUSE_S)
            commands.wait_until_sent()
        return findings

    def _go(self, commands: CmdVelPublisher, robot: LabRobot) -> str:
        """Drive forward and back, twice if the first time does not prove the robot."""
        x, y, theta = self._watch.poses()[robot.number]
        self._drive(commands, robot, (0.0, 0.0), _STILL_S)
        self._drive(commands, robot, (CRAWL_M_S, 0.0), _FORWARD_S)
        there = self._watch.poses()[robot.number]
        self._drive(commands, robot, (-CRAWL_M_S, 0.0), _FORWARD_S)
        if not self._motion.is_proved(robot.number):
            for speed in (CRAWL_M_S, -CRAWL_M_S):
                self._drive(commands, robot, (speed, 0.0), _FORWARD_S)
        if not self._motion.is_proved(robot.number):
            way = f'moved less than {100 * PROOF_M:.0f} cm in all'
            raise _AbortedError(way, 'check its wheels and the floor')
        moved = complex(there[0] - x, there[1] - y) / cmath.rect(1.0, theta)
        off = round(math.degrees(cmath.phase(moved)))
        return f'{100 * abs(moved):.1f} cm forward, {off:+d} deg off'

    def _turn(self, commands: CmdVelPublisher, robot: LabRobot) -> str:
        before = self._watch.poses()[robot.number][2]
        self._drive(commands, robot, (0.0, _TURN_RATE), _TURN_S)
        turned = float(wrap_angle(self._watch.poses()[robot.number][2] - before))
        self._drive(commands, robot, (0.0, -_TURN_RATE), _TURN_S)
        return f'{round(math.degrees(turned)):+d} deg to the left'

    def _drive(
        self,
        commands: CmdVelPublisher,
        robot: LabRobot,
        velocities: tuple[float, float],
        seconds: float,
    ) -> None:
        """Drive at forward speed and turn rate (m/s, rad/s), then let the robot settle.

        Raises:
            _AbortedError: A robot does not move as commanded, or may no longer be driven.
        """
        start = self._watch.poses()
        for commanded, duration in ((velocities, seconds), ((0.0, 0.0), _SETTLING_S)):
            begin = time.monotonic()
            while (elapsed := time.monotonic() - begin) < duration:
                self._command(commands, robot.number, commanded)
                self._process.spin_until(lambda: False, min(_PERIOD_S, duration - elapsed))
                self._check(start)
                conflict = self._watch.rival(robot) or self._watch.source_conflict(robot.number)
                if conflict:
                    raise _AbortedError(conflict)

    def _command(
        self, commands: CmdVelPublisher, robot: int, velocities: tuple[float, float]
    ) -> None:
        """Command one robot (m/s, rad/s), and note that all others must be at rest."""
        now = time.monotonic()
        self._paused.publish(Bool(data=False))
        commands.publish(*velocities)
        self._motion.commanded({robot: velocities}, now)
        for number, watch in self._watch.robots.items():
            watch.track.note_command(number == robot and any(velocities), False, now)

    def _pause(self, commands: CmdVelPublisher, seconds: float) -> None:
        end = time.monotonic() + seconds
        self._motion.commanded({}, time.monotonic())
        while (now := time.monotonic()) < end:
            self._paused.publish(Bool(data=True))
            commands.publish(0.0, 0.0)
            self._process.spin_until(lambda: False, _PERIOD_S)  # poses must not queue up
            time.sleep(max(0.0, now + _PERIOD_S - time.monotonic()))  # spins no more when stopping

    def _check(self, start: dict[int, Pose]) -> None:
        """Check that motion capture sees every robot move as commanded.

        Raises:
            _AbortedError: It does not.
        """
        if self._process.stopping:
            raise _AbortedError('stopped by the user')
        robots = self._watch.robots
        self._motion.see(
            {number: watch.track for number, watch in robots.items()},
            {number: watch.wheels for number, watch in robots.items()},
            time.monotonic(),
        )
        poses = self._watch.poses()
        for robot, (x, y, _) in start.items():
            name = robot_name(robot)
            if trouble := robots[robot].track.trouble:
                raise _AbortedError(f'{name}: {trouble}')
            if trouble := self._motion.trouble(robot):
                happened, _, check = trouble.partition(': ')
                raise _AbortedError(f'{name} {happened}', check)
            if robot not in poses or self._is_lost(robot):
                raise _AbortedError(f'motion capture lost {name}')
            if math.hypot(poses[robot][0] - x, poses[robot][1] - y) > _TOO_FAR_M:
                raise _AbortedError(f'{name} moved further than it should')


class _AbortedError(Exception):
    """A nudge ended early; `advice` says what to do."""

    def __init__(
        self, found: str, advice: str = 'clear its way, and stop everything else that commands it'
    ) -> None:
        super().__init__(found)
        self.advice = advice
