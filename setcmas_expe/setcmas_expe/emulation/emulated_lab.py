"""Emulated lab: TurtleBot3s, motion capture and their faults, without hardware.

Run as `ros2 run setcmas_expe emulated_lab --nb-robots 8`.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Quaternion, TransformStamped, Vector3
from nav_msgs.msg import Odometry
from rclpy.logging import LoggingSeverity, set_logger_level
from std_msgs.msg import String

from setcmas_expe.emulation.emulated_fleet import LIDAR_RATE_HZ, EmulatedFleet
from setcmas_expe.emulation.emulated_mocap import EmulatedMocap
from setcmas_expe.emulation.emulated_turtlebot3 import EmulatedTurtleBot3
from setcmas_expe.emulation.emulation_options import (
    EmulationOptions,
    check_emulated_mocap,
    emulated_start_poses,
)
from setcmas_expe.emulation.faults import Fault, FaultKind, parse_fault
from setcmas_expe.guard.guard_node import RATE_HZ, CmdVelGuard, GuardOptions
from setcmas_expe.lab.lab import Lab, LabRobot
from setcmas_expe.lab.lab_file import LabOptions
from setcmas_expe.mocap.sources import Sample
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.planar_pose import Pose
from setcmas_simu.robot_node import StepTime, run_steps
from setcmas_simu.robots.model import ROBOT_LIMITS
from setcmas_simu.ros import messages, qos
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.process import RosProcess, node_main, prefer_this_process
from setcmas_simu.ros.simulator_watch import refuse_second_simulator


class Schedule:
    """Due times of an event at a rate."""

    def __init__(self, rate: float) -> None:
        """Prepare for a rate in Hz."""
        self._period = 1.0 / rate
        self._next = 0.0

    def due(self, now: float) -> bool:
        """Return whether the event is due at time now (s), once per period."""
        if now < self._next:
            return False
        # Half a period early or late keeps the rate; long gaps are not caught up.
        self._next = max(self._next + self._period, now + 0.5 * self._period)
        return True


class EmulatedMocapDriver(FleetNode):
    """Publishes measurements, best effort as real drivers do."""

    def __init__(self, lab: Lab) -> None:
        super().__init__(f'{lab.mocap.preset}_driver')
        self._type = lab.mocap.source.message_class()
        self._bodies = [
            self.create_publisher(self._type, lab.mocap.topic_of(robot), qos.SENSOR)
            for robot in lab.robots
        ]

    def publish(self, body: int, sample: Sample, stamp: float) -> None:
        """Publish a measurement under the name of its body, with a stamp in s since 1970."""
        x, y, z = sample.position
        rotation = Quaternion(**dict(zip('xyzw', sample.orientation, strict=True)))
        message = self._type()
        message.header.stamp = messages.stamp_of(round(1e9 * stamp))
        message.header.frame_id = 'mocap'
        if isinstance(message, TransformStamped):
            message.transform.translation = Vector3(x=x, y=y, z=z)
            message.transform.rotation = rotation
        else:
            pose = message.pose.pose if isinstance(message, Odometry) else message.pose
            pose.position, pose.orientation = Point(x=x, y=y, z=z), rotation
        self._bodies[body].publish(message)


class EmulatedGuards:
    """The guards of some robots, by index."""

    def __init__(self, robots: Sequence[LabRobot], options: GuardOptions) -> None:
        self._robots = robots
        self._options = options
        self._guards = [self._guard(robot) for robot in robots]
        self._hang_until = [-math.inf] * len(robots)
        self._steps = Schedule(RATE_HZ)

    def hang(self, index: int, until: float) -> None:
        """Suspend a guard until a time (s)."""
        if self._guards:
            self._hang_until[index] = until

    def restart(self, index: int) -> None:
        """Restart a guard."""
        if self._guards:
            self._guards[index].destroy_node()
            self._guards[index] = self._guard(self._robots[index])

    def step(self, now: float) -> None:
        """Step all guards that do not hang; `now` is in s."""
        due = self._steps.due(now)
        for guard, until in zip(self._guards, self._hang_until, strict=True):
            if due and now >= until:
                guard.time.begin_step(now)
                guard.step()

    def _guard(self, robot: LabRobot) -> CmdVelGuard:
        """Return the guard of a robot; it logs only stops."""
        name = f'{robot.namespace}.{topics.CMD_VEL_GUARD_NODE}'.replace('/', '.')
        set_logger_level(name, LoggingSeverity.WARN)
        return CmdVelGuard(
            self._options, namespace=robot.namespace, start_parameter_services=False
        )


LAB_RATE_HZ = 50.0
"""Rate in Hz of motion capture, and of emulated robots: they follow a command at the next step."""

_LONGEST_STEP_S = 0.1  # so that robots do not jump after a stall
_WHEEL_ODOMETRY_HZ = 20.0
_BATTERY_HZ = 1.0
_REQUESTS_HZ = 10.0
_PERSON_AHEAD_M, _PERSON_RADIUS_M = 0.45, 0.15


class EmulatedLab(FleetNode):
    """Steps robots and motion capture, and injects faults."""

    def __init__(self, lab: Lab, options: EmulationOptions) -> None:
        """Create the lab's nodes; nothing moves before `start`.

        Raises:
            SetcmasError: A start pose is malformed, or another process emulates its robots.
        """
        super().__init__('emulated_lab')
        numbers = [robot.number for robot in lab.robots]
        check_emulated_mocap(lab.mocap)
        own_topics = {robot.number: robot.topic(topics.ODOM) for robot in lab.robots}
        refuse_second_simulator(self, numbers, own_topics.__getitem__)
        arena = lab.arena
        self._middle = ((arena.xmin + arena.xmax) / 2, (arena.ymin + arena.ymax) / 2)
        rng = np.random.default_rng(options.seed)
        model = 'waffle' if lab.limits == ROBOT_LIMITS['waffle'] else 'burger'
        poses = emulated_start_poses(lab.arena, lab.nb_robots, options)
        self._fleet = EmulatedFleet(poses, ROBOT_LIMITS[model], rng, options.robot_model(numbers))
        self._mocap = EmulatedMocap(lab.nb_robots, lab.mocap.y_up, rng)
        self.driver = EmulatedMocapDriver(lab)
        self._robots = [
            EmulatedTurtleBot3(
                robot,
                topics.CMD_VEL_GUARDED if lab.guarded else topics.CMD_VEL,
                partial(self._fleet.command, index),
                partial(self._fleet.set_torque, index),
            )
            for index, robot in enumerate(lab.robots)
        ]
        self._robot_guards = EmulatedGuards(
            lab.robots if lab.guarded else (), GuardOptions(limits=model, lidar=lab.lidar_stop)
        )
        self._off_until = [0.0] * lab.nb_robots
        self._people: dict[int, tuple[float, float, float]] = {}  # x, y in m, until when
        self._truth = Odometry()
        self._truth.header.frame_id = topics.WORLD_FRAME
        self._truth_publishers = [
            self.create_publisher(Odometry, topics.truth_topic(number), qos.EVENT)
            for number in numbers
        ]
        self.create_subscription(String, topics.EMULATED_FAULT, self._on_fault, qos.EVENT)
        self._wheel_odometry = Schedule(_WHEEL_ODOMETRY_HZ)
        self._batteries = Schedule(_BATTERY_HZ)
        self._lidars = Schedule(LIDAR_RATE_HZ) if lab.lidar_stop else None
        self._requests = Schedule(_REQUESTS_HZ)
        self._stepped = time.monotonic()
        robots = f'{lab.nb_robots} TurtleBot3{"s" if lab.nb_robots > 1 else ""}'
        self.get_logger().info(f'emulating a lab with {robots}; Ctrl-C stops')

    def step(self, now: float) -> None:
        """Move the robots by their commands, and publish; `now` is in s."""
        answers = self._requests.due(now)
        for index, robot in enumerate(self._robots):
            robot.commands.take()
            if answers:
                robot.requests.wait(0.0)
            if now < self._off_until[index]:
                self._fleet.command(index, 0.0, 0.0)
            elif self._off_until[index]:
                self._off_until[index] = 0.0
                self._robot_guards.restart(index)
        # By the clock: robots roll on while this process is late.
        self._fleet.step(min(now - self._stepped, _LONGEST_STEP_S))
        self._stepped = now
        self._publish_truth()
        self._publish_frames(now)
        self._publish_robots(now)
        self._robot_guards.step(now)

    def _publish_truth(self) -> None:
        self._truth.header.stamp = self.get_clock().now().to_msg()
        motions = self._motions(self._fleet.poses)
        for publisher, motion in zip(self._truth_publishers, motions, strict=True):
            messages.fill_odometry(self._truth, *motion)
            publisher.publish(self._truth)

    def _motions(self, poses: Floats) -> Iterator[tuple[Pose, float, float]]:
        """Return the pose of each robot, and the speeds of its wheels."""
        speeds = self._fleet.V.tolist(), self._fleet.omega.tolist()
        return zip(poses.T.tolist(), *speeds, strict=True)

    def _publish_frames(self, now: float) -> None:
        # Stamps are of the system's clock, as a driver's are.
        offset = time.time() - now
        self._mocap.capture(self._fleet.poses, now)
        for body, sample in self._mocap.due(now):
            self.driver.publish(body, sample, sample.stamp + offset)

    def _publish_robots(self, now: float) -> None:
        stamp = self.get_clock().now().to_msg()
        if self._wheel_odometry.due(now):
            motions = self._motions(self._fleet.odometry)
            for robot, off, motion in zip(self._robots, self._off_until, motions, strict=True):
                if not off:
                    robot.publish_odometry(stamp, *motion)
        if self._lidars and self._lidars.due(now):
            self._publish_scans(stamp, now)
        if self._batteries.due(now):
            for robot, percent in zip(self._robots, self._fleet.battery.tolist(), strict=True):
                robot.publish_battery(stamp, percent)

    def _publish_scans(self, stamp: Time, now: float) -> None:
        """Publish what the lidar of each robot sees of people and of the other robots."""
        people = [(x, y, _PERSON_RADIUS_M) for x, y, until in self._people.values() if now < until]
        discs = np.array(people).reshape(-1, 3).T
        for index, (robot, off) in enumerate(zip(self._robots, self._off_until, strict=True)):
            if not off:
                robot.publish_scan(stamp, self._fleet.scan(index, discs))

    def _on_fault(self, message: String) -> None:
        try:
            fault = parse_fault(message.data)
            if not 1 <= fault.robot <= len(self._robots):
                raise SetcmasError(
                    f"fault '{fault}' is for robot {fault.robot}; "
                    f'the lab has robots 1 to {len(self._robots)}'
                )
        except SetcmasError as error:
            self.get_logger().warning(str(error))
            return
        self.get_logger().info(
            f'robot {fault.robot}, for {fault.duration:g} s: {fault.kind.value}'
        )
        self._begin(fault, fault.robot - 1, time.monotonic())

    def _begin(self, fault: Fault, index: int, now: float) -> None:
        self._mocap.begin(fault, now)
        if fault.kind in (FaultKind.OFF, FaultKind.UNGUARDED):
            self._robot_guards.hang(index, now + fault.duration)
        if fault.kind == FaultKind.OFF:
            self._off_until[index] = now + fault.duration
        elif fault.kind == FaultKind.PUSH:
            self._fleet.push_outwards(index, self._middle, fault.duration)
        elif fault.kind in (FaultKind.STALLED, FaultKind.DEAF, FaultKind.BLOCKED):
            self._fleet.fail(fault.kind, index, fault.duration)
        elif fault.kind == FaultKind.PERSON:
            x, y, theta = self._fleet.poses[:, index].tolist()
            ahead = _PERSON_AHEAD_M * math.cos(theta), _PERSON_AHEAD_M * math.sin(theta)
            self._people[index] = x + ahead[0], y + ahead[1], now + fault.duration
        elif fault.kind == FaultKind.LIFT:
            self._fleet.fail(FaultKind.BLOCKED, index, fault.duration)


def main(argv: list[str] | None = None) -> int:
    """Emulate a lab until a signal arrives; return the exit status."""
    parser = argparse.ArgumentParser(prog='emulated_lab', description=__doc__)
    LabOptions.add_to(parser)
    EmulationOptions.add_to(parser)
    prefer_this_process()  # it holds the guards
    return node_main(parser, _emulate, argv)


def _emulate(process: RosProcess, args: argparse.Namespace) -> None:
    lab = EmulatedLab(LabOptions.of(args).chosen(), EmulationOptions.of(args))
    process.add(lab, lab.driver)
    process.launcher.report_ready()
    step_time = StepTime(1.0 / LAB_RATE_HZ)
    run_steps(process, step_time, lambda: lab.step(step_time.now))


if __name__ == '__main__':
    sys.exit(main())
