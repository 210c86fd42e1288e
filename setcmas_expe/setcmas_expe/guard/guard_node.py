"""Guard on a robot's own computer: a node that passes commands on to its base, or stops it.

A TurtleBot3 keeps its last velocity when its commander or the network dies. Where its base
listens to the guard's topic (cmd_vel_guarded), the guard decides; where it listens to cmd_vel
directly, the guard only commands zero there after a silence or in a stop.

    ros2 run setcmas_expe cmd_vel_guard --ros-args -r __ns:=/tb3_1
"""

from __future__ import annotations

import argparse
import contextlib
import math
import os
import socket
import sys
from dataclasses import dataclass
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.duration import Duration
from rclpy.publisher import Publisher
from sensor_msgs.msg import LaserScan

from setcmas_ctrl.experiment_pause import EmergencyWatch, PauseWatch
from setcmas_expe.guard import lidar
from setcmas_expe.guard.guard_commands import STOP, Commands
from setcmas_expe.guard.guard_decision import GuardDecision, GuardSituation, GuardState, StartLatch
from setcmas_expe.guard.guard_watch import GuardReport
from setcmas_expe.guard.motor_power import MotorPower
from setcmas_expe.guard.obedience import Disobedience, Obedience
from setcmas_expe.guard.surroundings import Base, Surroundings
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.topics import CMD_VEL_TYPES
from setcmas_simu.options.group import Options, flag, option
from setcmas_simu.options.kinds import OneOf
from setcmas_simu.robot_node import RobotNode, stepping
from setcmas_simu.robots.model import LIMITS, limits_named
from setcmas_simu.ros import qos
from setcmas_simu.ros.cmd_vel_topics import TYPES, command, filled, velocities
from setcmas_simu.ros.polling import PolledTopic, RequestWait
from setcmas_simu.ros.process import RosProcess, node_main, prefer_this_process


@dataclass(frozen=True, kw_only=True)
class GuardOptions(Options):
    """What a guard receives, and what it passes on."""

    limits: str = option(OneOf(tuple(LIMITS)), 'speed limits of the robot', default='burger')
    lidar: bool = flag(
        'stop the robot when its lidar (topic scan) sees something within its braking distance '
        'in its way, or falls silent'
    )


RATE_HZ = 20.0
"""Rate of steps in Hz."""

_REPORT_EVERY_S = 0.2
_LOOK_EVERY_S = 0.5
_LAST_ZERO_S = 0.3
_MOTORS_OFF = (GuardState.EMERGENCY, GuardState.INTRUDED, GuardState.DEAF)
_DEFENDED = (*_MOTORS_OFF, GuardState.CONTESTED, GuardState.OBSTRUCTED, GuardState.BLIND)


class CmdVelGuard(RobotNode):
    """Decides what reaches the wheels of robot i: cmd_vel in, cmd_vel_guarded out.

    Attributes:
        base: How the robot's base listens.
        commands: What the robot is commanded.
        sent: What its base was last told: V in m/s, omega in rad/s.
    """

    fleet_namespace = ''  # the fleet's topics are in the root, whatever the robot's namespace is

    def __init__(self, options: GuardOptions | None = None, **of_node: Any) -> None:
        """Create the topics of a robot; `of_node` is for `RobotNode`."""
        super().__init__(topics.CMD_VEL_GUARD_NODE, follows_clock=False, **of_node)
        self.time.period = 1.0 / RATE_HZ
        self.options = options or GuardOptions()
        self.limits = limits_named(self.options.limits)
        self.surroundings = Surroundings(self)
        self.pause, self.emergency = PauseWatch(self, latches=True), EmergencyWatch(self)
        self.motors, self.obedience = MotorPower(self), Obedience(self.limits)
        self.wheels = self.newest(Odometry, topics.ODOM, qos.SENSOR)
        self.scan = self.newest(LaserScan, topics.SCAN, qos.SENSOR) if self.options.lidar else None
        self._scan, self._scanned = LaserScan(), -math.inf
        self.reports = self.publisher(DiagnosticStatus, topics.GUARD_STATE, qos.STATE)
        self.latch = StartLatch()
        self.report = GuardReport(GuardDecision(GuardState.IDLE), False)
        self.sent = STOP
        self._stepped = self._looked = self._reported = self.time.now - _LOOK_EVERY_S
        self._use(Base())

    def step(self) -> None:
        """Decide on new messages, and command the base."""
        now = self.time.now
        if now - self._looked >= _LOOK_EVERY_S:
            self._looked = now
            self._look_around()
        self._cmd_vel.take()
        self._take_wheels()
        commanders = self.surroundings.commanders()
        if len(commanders) != 1:
            self.commands.forget_clock()
        situation = GuardSituation(
            emergency=self.emergency.take(),
            commanders=commanders,
            intruders=self.surroundings.intruders(),
            disobeys=self._disobeys(),
            base_listens=self.base.is_there,
            has_ended=self._have_commands_ended(),
            clearance=self._clearance(),
        )
        before = self.report.state
        decision = self.latch.decide(situation, self.pause.reason())
        self._switch_motors(before, decision.state)
        self._command(decision.state)
        self._publish_report(decision)
        self._stepped = now

    def stop(self) -> None:
        """Stop the robot before the publishers to its base close."""
        self._publish(*STOP)
        for publisher in self._to_base:
            publisher.wait_for_all_acked(Duration(seconds=_LAST_ZERO_S))

    def _look_around(self) -> None:
        """Follow a base that listens to another topic than before; stop the robot then."""
        base = self.surroundings.base()
        if base == self.base:
            return
        self.stop()
        self._cmd_vel.close()
        for publisher in self._to_base:
            self.destroy_publisher(publisher)
        self._use(base)
        self.latch.hold('its base listens to another topic than before')
        if base.is_open:
            self.warn(
                f'the base listens to {self.surroundings.cmd_vel}: every node on the network can '
                f'move it; remap it to {topics.CMD_VEL_GUARDED} (docs/lab_setup.md)'
            )
        elif base.is_there:
            self.get_logger().info(f'the base listens to its guard alone ({base.kind})')

    def _use(self, base: Base) -> None:
        """Publish to the base on its topics, with its type of message."""
        self.base = base
        kind = base.kind if base.is_open else CMD_VEL_TYPES[0]  # as the bridge finds listeners
        self._cmd_vel = PolledTopic(
            self, TYPES[kind], topics.CMD_VEL, self._on_cmd_vel, qos.COMMAND
        )
        # A base that only seems to listen to cmd_vel gets zeros on the guard's topic, too.
        names = [topics.CMD_VEL_GUARDED, *([topics.CMD_VEL] if base.is_open else [])]
        self._to_base: list[Publisher] = [
            self.create_publisher(TYPES[base.kind], topic, qos.COMMAND) for topic in names
        ]
        self._frame = f'{self._name}/base_footprint'
        self.commands = Commands(self.time.now, hears_itself=base.is_open)

    def _on_cmd_vel(self, message: Twist | TwistStamped) -> None:
        # Not on an open topic: there the guard's own zeros come back, stamped by its own clock.
        if isinstance(message, TwistStamped) and not self.base.is_open:
            sent = message.header.stamp
            if self.commands.is_late(sent.sec + 1e-9 * sent.nanosec, self.time.now):
                return
        # It came after the last step, and counts as that old: this process may have stalled.
        self.commands.receive(*velocities(message), self._stepped)

    def _take_wheels(self) -> None:
        if message := self.wheels():
            self.obedience.measure(*velocities(message.twist.twist), self.time.now)

    def _have_commands_ended(self) -> bool:
        """Return whether there is no command to follow."""
        if self.base.is_open:
            return self.commands.must_repeat_zero(self.time.now)
        return self.commands.have_ended(self.time.now)

    def _clearance(self) -> float:
        """Return how far ahead something stands within the braking distance, in m.

        It is inf if nothing does, or the robot is not to drive; NaN if the lidar is blind.
        """
        if not self.scan:
            return math.inf
        if scan := self.scan():
            self._scan, self._scanned = scan, self.time.now
        if self.time.now - self._scanned > lidar.SILENT_AFTER_S:
            return math.nan
        V, _ = self.limits.scaled_down(*self.commands.newest(self.time.now))
        scan, width = self._scan, self.limits.wheel_separation
        found = lidar.clearance(scan.ranges, scan.angle_min, scan.angle_increment, V, width)
        return math.inf if found >= lidar.braking_distance(V) else found

    def _switch_motors(self, before: GuardState, state: GuardState) -> None:
        """Switch the motors: off where zeros do not or may not help, on only by a start."""
        if state in _MOTORS_OFF or (state is GuardState.CONTESTED and self.base.is_open):
            self.motors.cut()
        elif state is GuardState.FOLLOWING and before is not state:
            self.motors.give()
        elif state is not GuardState.FOLLOWING:
            self.motors.leave()
        self.motors.step(self.time.now)

    def _disobeys(self) -> bool:
        """Return whether the base goes on despite zero, whoever commands it."""
        commanded = self.commands.newest(self.time.now) if self.base.is_open else self.sent
        found = self.obedience.update(*commanded, self.time.now)
        ignores = found is Disobedience.IGNORES_ZERO
        # Between experiments a person may push an open base, and then drive it without a start.
        return ignores and not (self.base.is_open and self.obedience.came_to_rest)

    def _command(self, state: GuardState) -> None:
        """Tell the base what it may do; an open base only zero."""
        now = self.time.now
        if self.base.is_open:
            if self.commands.must_repeat_zero(now) or state in _DEFENDED:
                self._publish(*STOP)
            return
        wanted = self.commands.newest(now) if state is GuardState.FOLLOWING else STOP
        self.sent = self.limits.scaled_down(*wanted)
        self._publish(*self.sent)

    def _publish(self, V: float, omega: float) -> None:
        for publisher in self._to_base:
            publisher.publish(filled(command(self.base.kind, self._frame), V, omega))

    def _publish_report(self, decision: GuardDecision) -> None:
        """Publish the decision, at once if it is new; log it if it stops the robot."""
        private = self.base.is_there and not self.base.is_open
        report = GuardReport(decision, private, self.options.lidar)
        if report == self.report and self.time.now - self._reported < _REPORT_EVERY_S:
            return
        was, state = self.report.state, decision.state
        is_news = was is GuardState.FOLLOWING or state in _DEFENDED
        if state.stops and state is not was and is_news:
            self.warn(f'{self._name} is stopped: {decision.reason}')
        self.report, self._reported = report, self.time.now
        self.reports.publish(report.message(self._name, self.surroundings.cmd_vel))

    @property
    def _name(self) -> str:
        return str(self.get_namespace().strip('/'))


def main(argv: list[str] | None = None) -> int:
    """Guard until a signal arrives; return the exit status."""
    parser = argparse.ArgumentParser(prog='cmd_vel_guard', description=__doc__)
    GuardOptions.add_to(parser)
    prefer_this_process()
    return node_main(parser, _guard, argv)


def notify(state: str) -> None:
    """Tell systemd, if that started this process, a state of sd_notify(3), such as WATCHDOG=1."""
    address = os.environ.get('NOTIFY_SOCKET', '')
    if not address:
        return
    where = f'\0{address[1:]}' if address.startswith('@') else address
    kind = socket.SOCK_DGRAM | socket.SOCK_NONBLOCK
    # An error here is no reason to stop guarding the robot.
    with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, kind) as systemd:
        systemd.sendto(state.encode(), where)


def _guard(process: RosProcess, args: argparse.Namespace) -> None:
    guard = CmdVelGuard(GuardOptions.of(args))
    process.requests = RequestWait([guard])
    notify('READY=1')
    try:
        stepping(process, guard.time, [[guard]], bool, lambda: notify('WATCHDOG=1')).run()
    finally:
        guard.stop()


if __name__ == '__main__':
    sys.exit(main())
