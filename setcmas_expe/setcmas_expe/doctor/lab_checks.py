"""Checks of the robots of a lab: the rate of their poses, their commands, guards and batteries."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

from setcmas_expe.doctor.findings import NOTE, PROBLEM, Finding
from setcmas_expe.guard.guard_decision import GuardDecision
from setcmas_expe.lab.lab import LOW_PERCENT, Lab, LabRobot
from setcmas_simu.fleet.planar_pose import Pose
from setcmas_simu.fleet.topics import AUTO, CMD_VEL, CMD_VEL_TYPES, robot_name

_NEARLY_LOW_PERCENT = 30.0
_SLOWEST_HZ = 10.0


@dataclass(frozen=True)
class ArrivalStatistics:
    """The regularity of one topic.

    Attributes:
        rate: Messages per second.
        largest_gap: In s, including the time before the first and after the last message.
    """

    rate: float
    largest_gap: float


def arrival_statistics(arrivals: list[float], begin: float, end: float) -> ArrivalStatistics:
    """Return the regularity of messages from `begin` to `end`, all in s."""
    times = [begin, *arrivals, end]
    largest = max(later - earlier for earlier, later in itertools.pairwise(times))
    gaps = [later - earlier for earlier, later in itertools.pairwise(arrivals)]
    rate = len(gaps) / sum(gaps) if sum(gaps) > 0 else 0.0
    return ArrivalStatistics(rate, largest)


COLUMNS = ('robot', 'mocap', 'gap', 'place', 'cmd_vel', 'guard', 'battery')

_Remark = tuple[str, str, str, str]
"""Level, part of the robot, result and advice."""


@dataclass(frozen=True)
class RobotCheck:
    """Measurements of one robot.

    Attributes:
        mocap: Regularity of its poses.
        pose: The last good pose (m, rad); None if there is none.
        fault: The fault of its poses; None if they are good.
        kinds: The message types of the listeners to its cmd_vel.
        rival: Who else may move it, or move in its place; empty if none.
        guard: Last report of its cmd_vel_guard; None if there is none.
        battery: Charge in percent; None if unknown.
    """

    robot: LabRobot
    mocap: ArrivalStatistics
    pose: Pose | None
    fault: str | None
    kinds: list[str]
    rival: str
    guard: GuardDecision | None
    battery: float | None

    def row(self) -> list[str]:
        """Return the robot's line in the table of COLUMNS."""
        mocap, pose = self.mocap, self.pose
        seen = mocap.rate > 0
        return [
            robot_name(self.robot.number),
            f'{mocap.rate:.0f} Hz' if seen else 'silent',
            f'{1e3 * mocap.largest_gap:.1f} ms' if seen else '-',
            f'{pose[0]:.2f}, {pose[1]:.2f}, {round(math.degrees(pose[2]))} deg' if pose else '-',
            ', '.join(dict.fromkeys(self.kinds)) or 'no node',
            self._guard_state(),
            '-' if self.battery is None else f'{self.battery:.0f} %',
        ]

    def _guard_state(self) -> str:
        if self.guard is None:
            return 'no'
        return self.guard.state.value if self.guard.state.stops else 'yes'

    def findings(self, lab: Lab, bodies: list[str]) -> list[Finding]:
        """Return all problems and notes; `bodies` are the names that motion capture sends."""
        name = robot_name(self.robot.number)
        remarks = itertools.chain(
            self._of_mocap(lab, bodies),
            self._of_commands(lab),
            self._of_guard(lab),
            self._of_power(),
        )
        return [
            Finding(level, f'{part} of {name}', found, advice)
            for level, part, found, advice in remarks
        ]

    def _of_mocap(self, lab: Lab, bodies: list[str]) -> Iterator[_Remark]:
        if not self.mocap.rate:
            received = ', '.join(bodies) or 'no bodies'
            advice = (
                f'motion capture sends {received} on {lab.mocap.source.topic}: check that its '
                'driver is running, that cameras see the robot, and preset and mocap_name in the '
                'lab file'
            )
            yield PROBLEM, 'mocap', f'nothing on {lab.mocap.topic_of(self.robot)}', advice
            return
        if self.fault:
            advice = 'look at the body in the motion capture system'
            yield PROBLEM, 'mocap', self.fault, advice
        elif self.pose and lab.arena.distance(*self.pose[:2]) > 0:
            advice = 'put it inside, or widen the arena in the lab file'
            yield PROBLEM, 'place', 'outside the arena', advice
        if self.mocap.largest_gap > lab.timeouts.pose_s:
            advice = 'the robot would stop: keep it in view, and check the network'
            yield PROBLEM, 'mocap', f'silent for {self.mocap.largest_gap:.1f} s', advice
        elif self.mocap.rate < _SLOWEST_HZ:
            advice = f'let motion capture send at {_SLOWEST_HZ:g} Hz or more; 50 Hz is better'
            yield NOTE, 'mocap', f'only {self.mocap.rate:.1f} Hz', advice

    def _of_commands(self, lab: Lab) -> Iterator[_Remark]:
        if not self.kinds:
            advice = (
                'start the robot (ros2 launch turtlebot3_bringup robot.launch.py namespace:=... '
                'as in the lab file) with the same ROS_DOMAIN_ID; without multicast, add its '
                'address to network.static_peers in the lab file'
            )
            yield PROBLEM, 'cmd_vel', f'nothing listens to {self.robot.topic(CMD_VEL)}', advice
            return
        accepted = CMD_VEL_TYPES if lab.cmd_vel_type == AUTO else (lab.cmd_vel_type,)
        if others := [kind for kind in self.kinds if kind not in accepted]:
            advice = (
                f'cmd_vel_type is {lab.cmd_vel_type} in the lab file; robots take Twist(Stamped)'
            )
            yield PROBLEM, 'cmd_vel', f'it takes {others[0]}', advice
        if self.rival:
            advice = (
                'stop the other commander, and give each robot its own namespace (a restarted '
                'robot appears twice for up to 20 s)'
            )
            yield PROBLEM, 'cmd_vel', self.rival, advice

    def _of_guard(self, lab: Lab) -> Iterator[_Remark]:
        if self.guard is None:
            advice = (
                'a robot keeps its last velocity when this machine or the network dies; install '
                'cmd_vel_guard on it (docs/lab_setup.md)'
            )
            yield PROBLEM, 'guard', 'not there', advice
            return
        if self.guard.state.stops:
            advice = 'remove the cause; in an experiment, R twice releases a stop'
            yield NOTE, 'guard', self.guard.reason, advice
        if lab.lidar_stop and not self.guard.lidar:
            advice = 'start it with --lidar, or set safety.lidar_stop: false in the lab file'
            yield PROBLEM, 'guard', 'it does not watch the lidar', advice

    def _of_power(self) -> Iterator[_Remark]:
        if self.battery is not None and self.battery < _NEARLY_LOW_PERCENT:
            level = PROBLEM if self.battery < LOW_PERCENT else NOTE
            yield level, 'battery', f'{self.battery:.0f} %', 'charge it'
