"""Examination of a lab over ROS: its robots, motion capture and guards."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial

from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import BatteryState

from setcmas_expe.guard.guard_decision import GuardDecision
from setcmas_expe.guard.guard_watch import GuardWatch
from setcmas_expe.lab.findings import NOTE, PROBLEM, Finding
from setcmas_expe.lab.lab import LOW_PERCENT, BatteryScale, Lab, LabRobot
from setcmas_expe.mocap.pose_judge import PoseJudge, fault_in_words, pose_fault
from setcmas_expe.mocap.receiver import MocapReceiver
from setcmas_expe.mocap.sources import Sample
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.planar_pose import Pose
from setcmas_simu.fleet.topics import CMD_VEL, CMD_VEL_TYPES, robot_name
from setcmas_simu.ros import cmd_vel_topics
from setcmas_simu.ros.cmd_vel_topics import Endpoint
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.polling import PolledTopic, RequestWait
from setcmas_simu.ros.process import ros_process

_NEARLY_LOW_PERCENT = 30.0
_SLOWEST_HZ = 10.0


def rate_and_gap(arrivals: list[float], begin: float, end: float) -> tuple[float, float]:
    """Return messages per second from `begin` to `end`, and their largest gap, in s.

    The time before the first message and after the last one is a gap, too.
    """
    times = [begin, *arrivals, end]
    largest = max(later - earlier for earlier, later in itertools.pairwise(times))
    gaps = [later - earlier for earlier, later in itertools.pairwise(arrivals)]
    rate = len(gaps) / sum(gaps) if sum(gaps) > 0 else 0.0
    return rate, largest


COLUMNS = ('robot', 'mocap', 'gap', 'place', 'cmd_vel', 'guard', 'battery')

_Remark = tuple[str, str, str, str]
"""Level, part of the robot, result and advice."""


@dataclass(frozen=True)
class RobotCheck:
    """Measurements of one robot.

    Attributes:
        rate: Poses per second.
        largest_gap: Longest time without a pose, in s.
        pose: The last good pose (m, rad); None if there is none.
        fault: The fault of its poses; None if they are good.
        kinds: The message types of the listeners to its cmd_vel.
        rival: Who else may move it, or move in its place; empty if none.
        guard: Last report of its cmd_vel_guard; None if there is none.
        battery: Charge in percent; None if unknown.
    """

    robot: LabRobot
    rate: float
    largest_gap: float
    pose: Pose | None
    fault: str | None
    kinds: list[str]
    rival: str
    guard: GuardDecision | None
    battery: float | None

    def row(self) -> list[str]:
        """Return the robot's line in the table of COLUMNS."""
        pose, is_seen = self.pose, self.rate > 0
        return [
            robot_name(self.robot.number),
            f'{self.rate:.0f} Hz' if is_seen else 'silent',
            f'{1e3 * self.largest_gap:.1f} ms' if is_seen else '-',
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
            self._of_commands(),
            self._of_guard(lab),
            self._of_power(),
        )
        return [
            Finding(level, f'{part} of {name}', found, advice)
            for level, part, found, advice in remarks
        ]

    def _of_mocap(self, lab: Lab, bodies: list[str]) -> Iterator[_Remark]:
        if not self.rate:
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
        if self.largest_gap > lab.timeouts.pose_s:
            advice = 'the robot would stop: keep it in view, and check the network'
            yield PROBLEM, 'mocap', f'silent for {self.largest_gap:.1f} s', advice
        elif self.rate < _SLOWEST_HZ:
            advice = f'let motion capture send at {_SLOWEST_HZ:g} Hz or more; 50 Hz is better'
            yield NOTE, 'mocap', f'only {self.rate:.1f} Hz', advice

    def _of_commands(self) -> Iterator[_Remark]:
        if not self.kinds:
            advice = (
                'start the robot (ros2 launch turtlebot3_bringup robot.launch.py namespace:=... '
                'as in the lab file) with the same ROS_DOMAIN_ID; without multicast, add its '
                'address to network.static_peers in the lab file'
            )
            yield PROBLEM, 'cmd_vel', f'nothing listens to {self.robot.topic(CMD_VEL)}', advice
            return
        if others := [kind for kind in self.kinds if kind not in CMD_VEL_TYPES]:
            advice = 'robots take Twist or TwistStamped: end the node that listens'
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


_BURST = QoSProfile(depth=50, reliability=ReliabilityPolicy.BEST_EFFORT)


@dataclass
class RobotWatch:
    """Messages of one robot since the watch began.

    Attributes:
        track: Its poses, and which of them to trust.
        guard: The watch over its guard.
        arrivals: When its poses arrived, in s on the system's clock.
        fault: What was wrong with the last bad pose; None if all were good.
        battery: Charge in percent; None if unknown.
        scale: Scale of its battery's messages.
    """

    robot: LabRobot
    track: PoseJudge
    guard: GuardWatch
    arrivals: list[float] = field(default_factory=list)
    fault: str | None = None
    battery: float | None = None
    scale: BatteryScale = field(default_factory=BatteryScale)


class LabWatch(FleetNode):
    """Listens to all robots of a lab and to its motion capture system.

    Attributes:
        robots: Messages of each robot.
        mocap: Receiver of motion capture.
        polled: Topics whose messages are to be taken when they come.
    """

    def __init__(self, lab: Lab) -> None:
        super().__init__('doctor')
        self._arena = lab.arena
        self.robots = [
            RobotWatch(robot, PoseJudge(lab.arena, lab.limits), GuardWatch(self, robot.namespace))
            for robot in lab.robots
        ]
        self._begin = time.time()
        takers = {one.robot.mocap_name: partial(self._on_mocap, one) for one in self.robots}
        self.mocap = MocapReceiver(self, lab.mocap.source, lab.mocap.y_up, takers, _BURST)
        self.polled = [*self.mocap.polled]
        for watch in self.robots:
            topic, callback = watch.robot.topic(topics.BATTERY), partial(self._on_battery, watch)
            self.polled.append(PolledTopic(self, BatteryState, topic, callback, _BURST))

    def restart_statistics(self) -> None:
        """Forget the poses received so far."""
        self._begin = time.time()
        self.take_guards()
        for watch in self.robots:
            watch.arrivals.clear()
            watch.fault = None

    def take_guards(self) -> None:
        """Take the new reports of all guards."""
        for watch in self.robots:
            watch.guard.take(time.monotonic())

    def listeners(self, robot: LabRobot) -> list[Endpoint]:
        """Return who receives a robot's commands, except recorders and displays."""
        return cmd_vel_topics.listeners(self, robot.topic(topics.CMD_VEL))

    def check(self, watch: RobotWatch) -> RobotCheck:
        """Return the measurements of a robot."""
        robot, guard = watch.robot, watch.guard
        guard.look_around()
        cmd_vel = robot.topic(topics.CMD_VEL)
        bridge = topics.robot_topic(robot.number, topics.CMD_VEL_BRIDGE)
        allowed = map(self.full_name, (bridge, f'/{topics.PAUSE_NODE}'))
        rivals = cmd_vel_topics.rivals(self, cmd_vel, *allowed)
        rate, largest_gap = rate_and_gap(watch.arrivals, self._begin, time.time())
        return RobotCheck(
            robot=robot,
            rate=rate,
            largest_gap=largest_gap,
            pose=None if watch.track.fault else watch.track.pose,
            fault=watch.fault or self.mocap.trouble(robot.mocap_name) or None,
            kinds=[listener.kind for listener in self.listeners(robot)],
            rival=guard.intruder or cmd_vel_topics.contest(self, cmd_vel, rivals),
            guard=guard.report if guard.is_there() else None,
            battery=watch.battery,
        )

    def _on_mocap(self, watch: RobotWatch, sample: Sample) -> None:
        watch.arrivals.append(time.time())
        watch.track.take(sample, time.monotonic())
        if fault := pose_fault(sample, self._arena):
            watch.fault = fault_in_words(fault, sample, self._arena)

    def _on_battery(self, watch: RobotWatch, message: BatteryState) -> None:
        watch.battery = watch.scale.percent(message.percentage)


_DISCOVERY_S = 3.0
_WATCH_S = 3.0


def examine(lab: Lab) -> tuple[list[list[str]], list[Finding]]:
    """Watch a lab for a while; return the rows of the table of robots, and the findings."""
    with ros_process() as process:
        watch = LabWatch(lab)
        process.requests = RequestWait([watch], watch.polled)

        def is_found() -> bool:
            return all(one.arrivals and watch.listeners(one.robot) for one in watch.robots)

        process.spin_until(is_found, _DISCOVERY_S)
        watch.restart_statistics()
        process.spin_until(lambda: False, _WATCH_S)
        if process.stopping:
            raise KeyboardInterrupt
        watch.take_guards()
        watch.mocap.look_around()
        checks = [watch.check(one) for one in watch.robots]
        bodies = watch.mocap.bodies()
        findings = [found for check in checks for found in check.findings(lab, bodies)]
        if watch.count_publishers(topics.PAUSED):
            findings.insert(0, Finding(NOTE, 'experiment', 'one is running'))
    return [check.row() for check in checks], findings
