"""Examination of a lab over ROS: its robots, motion capture and guards."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from functools import partial

from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import BatteryState

from setcmas_expe.doctor.findings import NOTE, Finding
from setcmas_expe.doctor.lab_checks import RobotCheck, arrival_statistics
from setcmas_expe.guard.guard_watch import GuardWatch
from setcmas_expe.lab.lab import BatteryScale, Lab, LabRobot
from setcmas_expe.mocap.pose_judge import PoseTrack, fault_in_words, pose_fault
from setcmas_expe.mocap.receiver import MocapReceiver
from setcmas_expe.mocap.sources import Sample
from setcmas_simu.fleet import topics
from setcmas_simu.ros import cmd_vel_topics
from setcmas_simu.ros.cmd_vel_topics import Endpoint
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.polling import PolledTopic, RequestWait
from setcmas_simu.ros.process import RosProcess

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
    track: PoseTrack
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
            RobotWatch(robot, PoseTrack(lab.arena, lab.limits), GuardWatch(self, robot.namespace))
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
        return RobotCheck(
            robot=robot,
            mocap=arrival_statistics(watch.arrivals, self._begin, time.time()),
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


def examine(process: RosProcess, lab: Lab) -> tuple[list[list[str]], list[Finding]]:
    """Watch a lab for a while; return the rows of the table of robots, and the findings."""
    watch = LabWatch(lab)
    process.requests = RequestWait([watch], watch.polled)

    def is_found() -> bool:
        return all(one.arrivals and watch.listeners(one.robot) for one in watch.robots)

    process.spin_until(is_found, _DISCOVERY_S)
    watch.restart_statistics()
    process.spin_until(lambda: False, _WATCH_S)
    watch.take_guards()
    watch.mocap.look_around()
    checks = [watch.check(one) for one in watch.robots]
    bodies = watch.mocap.bodies()
    findings = [found for check in checks for found in check.findings(lab, bodies)]
    if watch.count_publishers(topics.PAUSED):
        findings.insert(0, Finding(NOTE, 'experiment', 'one is running'))
    return [check.row() for check in checks], findings
