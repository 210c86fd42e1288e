"""Examination of a lab over ROS: its robots, motion capture and guards, and other fleets."""

from __future__ import annotations

import time
from collections import defaultdict
from dataclasses import dataclass, field
from functools import partial

from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import BatteryState

from setcmas_expe.doctor.findings import NOTE, OK, Finding
from setcmas_expe.doctor.lab_checks import (
    ArrivalStatistics,
    RobotCheck,
    arrival_statistics,
    other_presets,
)
from setcmas_expe.guard.guard_watch import GuardWatch
from setcmas_expe.lab.lab import Battery, Lab, LabRobot
from setcmas_expe.mocap.pose_track import PoseTrack
from setcmas_expe.mocap.receiver import MocapReceiver
from setcmas_expe.mocap.sample import Pose, Sample, fault_of
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.ros import cmd_vel_topics
from setcmas_simu.ros.cmd_vel_topics import Endpoint
from setcmas_simu.ros.fleet_topic import FleetListener
from setcmas_simu.ros.process import FleetNode, RosProcess

_BURST = QoSProfile(depth=50, reliability=ReliabilityPolicy.BEST_EFFORT)


@dataclass
class RobotWatch:
    """Messages of one robot since the watch began.

    Attributes:
        track: Its poses, and which of them to trust.
        arrivals: When its poses arrived, in s on the system's clock.
        stamps: Their stamps, in s.
        fault: What was wrong with the last bad pose; None if all were good.
        battery: Charge in percent; None if unknown.
        scale: Scale of its battery's messages.
    """

    robot: LabRobot
    track: PoseTrack
    arrivals: list[float] = field(default_factory=list)
    stamps: list[float] = field(default_factory=list)
    fault: str | None = None
    battery: float | None = None
    scale: Battery = field(default_factory=Battery)


class LabWatch(FleetNode):
    """Listens to all robots of a lab and to its motion capture system.

    Attributes:
        robots: Messages of each robot, by number.
        robot_guards: The watch over each robot's guard, by number.
        mocap: Receiver of motion capture.
    """

    def __init__(self, lab: Lab) -> None:
        super().__init__('doctor')
        self.lab = lab
        self.robots = {
            robot.number: RobotWatch(robot, PoseTrack(lab.arena, lab.limits))
            for robot in lab.robots
        }
        self.robot_guards = {
            robot.number: GuardWatch(self, robot.namespace) for robot in lab.robots
        }
        self._own = cmd_vel_topics.own_participant(self)
        self._begin = time.time()
        takers = {
            watch.robot.mocap_name: partial(self._on_mocap, watch)
            for watch in self.robots.values()
        }
        self.mocap = MocapReceiver(self, lab.mocap.source, lab.mocap.y_up, takers, _BURST)
        for watch in self.robots.values():
            topic = watch.robot.topic(topics.BATTERY)
            self.create_subscription(BatteryState, topic, partial(self._on_battery, watch), _BURST)

    def restart_statistics(self) -> None:
        """Forget the poses received so far."""
        self._begin = time.time()
        self.take_guards()
        for watch in self.robots.values():
            watch.arrivals.clear()
            watch.stamps.clear()
            watch.fault = None

    def take_guards(self) -> None:
        """Take the new reports of all guards."""
        for guard in self.robot_guards.values():
            guard.take(time.monotonic())

    def statistics(self, robot: int) -> ArrivalStatistics:
        """Return the regularity of a robot's poses."""
        watch = self.robots[robot]
        return arrival_statistics(watch.arrivals, watch.stamps, self._begin, time.time())

    def runs_experiment(self) -> bool:
        """Return whether another process pauses and starts the robots."""
        return bool(cmd_vel_topics.strangers(self, topics.PAUSED, {self._own}))

    def poses(self) -> dict[int, Pose]:
        """Return the last good pose of each robot that has one, by number."""
        return {
            number: watch.track.pose
            for number, watch in self.robots.items()
            if watch.track.pose and not watch.track.fault
        }

    def fault(self, robot: int) -> str | None:
        """Return the fault of a robot's poses; None if they are good."""
        self.mocap.look_around()
        watch = self.robots[robot]
        return watch.fault or self.mocap.trouble(watch.robot.mocap_name) or None

    def listeners(self, robot: LabRobot) -> list[Endpoint]:
        """Return who receives a robot's commands, except recorders and displays."""
        return cmd_vel_topics.listeners(self, robot.topic(topics.CMD_VEL))

    def rival(self, robot: LabRobot) -> str:
        """Return which process may move a robot, or moves in its place; empty if none.

        The processes of an experiment do not count.
        """
        topic = robot.topic(topics.CMD_VEL)
        guard = self.robot_guards[robot.number]
        allowed = {self._own} | guard.look_around()
        for name in (topics.FLEET, topics.PAUSED):
            allowed |= cmd_vel_topics.participants(self, name)
        return guard.intruder or cmd_vel_topics.rival(self, topic, allowed)

    def _on_mocap(self, watch: RobotWatch, sample: Sample) -> None:
        watch.arrivals.append(time.time())
        watch.stamps.append(sample.stamp)
        watch.track.take(sample, time.monotonic())
        watch.fault = fault_of(sample, self.lab.arena) or watch.fault

    def _on_battery(self, watch: RobotWatch, message: BatteryState) -> None:
        watch.battery = watch.scale.percent(message.percentage)


_SIGHT_S = 2.0
_DISCOVERY_S = 3.0
_WATCH_S = 3.0


def other_fleets(process: RosProcess) -> Finding:
    """Return the robots in sight: announced ones, and others by the sender of their odometry."""
    node = FleetNode('doctor')
    announced = FleetListener(node)
    process.add(node)
    process.spin_until(lambda: False, _SIGHT_S)
    fleets = {str(one.source): set(one.robots) for one in announced.take().values()}
    for sender, robots in _by_odometry(node).items():
        if others := robots.difference(*fleets.values()):
            fleets[sender] = others
    if not fleets:
        return Finding(OK, 'other fleets', 'none in sight in this ROS domain')
    found = '; '.join(
        f'{robots_in_words(sorted(robots))} of {sender}' for sender, robots in fleets.items()
    )
    advice = (
        'if they are not yours, set another ROS_DOMAIN_ID (0 to 101), the same on your machines '
        'and robots'
    )
    return Finding(NOTE, 'other fleets', found, advice)


def _by_odometry(node: Node) -> dict[str, set[int]]:
    senders: defaultdict[str, set[int]] = defaultdict(set)
    for name, _ in node.get_topic_names_and_types():
        robot = topics.robot_of(name)
        if robot and name == topics.robot_topic(robot, topics.ODOM):
            for info in node.get_publishers_info_by_topic(name):
                senders[info.node_name].add(robot)
    return senders


def watched_lab(process: RosProcess, lab: Lab) -> LabWatch:
    """Return a watch that has listened for a while, once it found all robots or waited enough."""
    watch = LabWatch(lab)
    process.add(watch)
    robots = watch.robots.values()
    process.spin_until(
        lambda: all(one.arrivals and watch.listeners(one.robot) for one in robots), _DISCOVERY_S
    )
    watch.restart_statistics()
    process.spin_until(lambda: False, _WATCH_S)
    return watch


def examine(watch: LabWatch) -> tuple[list[list[str]], list[Finding]]:
    """Return the rows of the table of robots, and the findings."""
    watch.take_guards()
    poses = watch.poses()
    checks = [
        RobotCheck(
            robot=one.robot,
            mocap=watch.statistics(number),
            pose=poses.get(number),
            fault=watch.fault(number),
            kinds=[listener.kind for listener in watch.listeners(one.robot)],
            rival=watch.rival(one.robot),
            guard=watch.robot_guards[number].recent_report,
            battery=one.battery,
        )
        for number, one in watch.robots.items()
    ]
    bodies = watch.mocap.bodies()
    findings = [found for check in checks for found in check.findings(watch.lab, bodies)]
    if not bodies:
        findings += other_presets(watch.get_topic_names_and_types(), watch.lab.mocap.preset)
    if watch.runs_experiment():
        findings.insert(0, Finding(NOTE, 'experiment', 'one is running'))
    return [check.row() for check in checks], findings
