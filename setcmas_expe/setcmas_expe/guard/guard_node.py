"""Guard on a robot's own computer: a node that passes commands on to its base, or stops it.

A TurtleBot3 keeps its last velocity when its commander or the network dies. So its base listens
to the guard's topic (cmd_vel_guarded) alone: a robot whose base listens to cmd_vel is stopped.

    ros2 run setcmas_expe cmd_vel_guard --ros-args -r __ns:=/tb3_1
"""

from __future__ import annotations

import argparse
import contextlib
import math
import os
import socket
import sys
from dataclasses import dataclass, replace
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan

from setcmas_ctrl.pause_watch import EmergencyWatch, PauseWatch
from setcmas_expe.guard import lidar
from setcmas_expe.guard.guard_decision import GuardDecision, GuardSituation, GuardState, StartLatch
from setcmas_expe.guard.guard_watch import report_message
from setcmas_expe.guard.motor_power import MotorPower
from setcmas_expe.guard.obedience import Disobedience, Obedience
from setcmas_simu.fleet import topics
from setcmas_simu.option_groups import Options, flag, option
from setcmas_simu.option_kinds import OneOf
from setcmas_simu.robot_node import RobotNode, run_steps
from setcmas_simu.robots.model import LIMITS, limits_named
from setcmas_simu.ros import cmd_vel_topics, messages, qos
from setcmas_simu.ros.cmd_vel_topics import NAMED_AFTER_S, CmdVelPublisher, NameWait, velocities
from setcmas_simu.ros.polling import RequestWait
from setcmas_simu.ros.process import RosProcess, node_main, prefer_this_process
from setcmas_simu.ros.stamp_clock import StampClock


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

SILENCE_S = 0.3
"""Silence at which the guard stops a robot, in s."""

LATEST_S = 0.2
"""Largest delay of a command that is followed, compared with the least seen, in s."""

_REPORT_EVERY_S = 0.2
_LOOK_EVERY_S = 0.5
_MOTORS_OFF = (GuardState.EMERGENCY, GuardState.INTRUDED, GuardState.DEAF)
_LOGGED = (*_MOTORS_OFF, GuardState.CONTESTED, GuardState.OPEN)
_NAMED_AT_START_S = 1.0  # where many processes start at once; the robot stands
_STOP = (0.0, 0.0)


class CmdVelGuard(RobotNode):
    """Decides what reaches the wheels of robot i: cmd_vel in, cmd_vel_guarded out.

    Attributes:
        sent: The last command to its base: V in m/s, omega in rad/s.
    """

    fleet_namespace = ''  # the fleet's topics are in the root, whatever the robot's namespace is

    def __init__(self, options: GuardOptions | None = None, **of_node: Any) -> None:
        """Create the topics of a robot; `of_node` is for `RobotNode`."""
        super().__init__(topics.CMD_VEL_GUARD_NODE, follows_clock=False, **of_node)
        self.time.period = 1.0 / RATE_HZ
        self.options = options or GuardOptions()
        self.limits = limits_named(self.options.limits)
        self.pause, self.emergency = PauseWatch(self, latches=True), EmergencyWatch(self)
        self.motors, self.obedience = MotorPower(self), Obedience(self.limits)
        self.cmd_vel = self.newest(TwistStamped, topics.CMD_VEL, qos.COMMAND)
        self.wheels = self.newest(Odometry, topics.ODOM, qos.SENSOR)
        self.scan = self.newest(LaserScan, topics.SCAN, qos.SENSOR) if self.options.lidar else None
        self._scan, self._scanned = LaserScan(), -math.inf
        self._cmd_vel, self._odom = map(self.resolve_topic_name, (topics.CMD_VEL, topics.ODOM))
        self.base = CmdVelPublisher(self, self.robot, topics.CMD_VEL_GUARDED, self._odom)
        self.reports = self.create_publisher(DiagnosticStatus, topics.GUARD_STATE, qos.STATE)
        self.latch, self._names = StartLatch(), NameWait()
        self.report = GuardDecision(GuardState.IDLE)
        self.sent = self._wanted = _STOP
        self._stamps, self._commanded = StampClock(), -math.inf
        self._trouble: GuardState | None = GuardState.UNCONNECTED
        self._stepped = self._looked = self._reported = self.time.now - _LOOK_EVERY_S

    def step(self) -> None:
        """Decide on new messages, and command the base."""
        now = self.time.now
        if now - self._looked >= _LOOK_EVERY_S:
            self._looked, self._trouble = now, self._trouble_of_base()
        pause = self.full_name(f'/{topics.PAUSE_NODE}')  # ready to command zero
        commanders = cmd_vel_topics.rivals(self, self._cmd_vel, pause)
        if len(commanders) != 1:
            self._stamps = StampClock()  # another computer, whose clock differs, may command it
        self._take_messages()
        situation = GuardSituation(
            emergency=self.emergency.take(),
            commanders=commanders,
            intruders=cmd_vel_topics.rivals(
                self, self.base.topic, self.get_fully_qualified_name()
            ),
            disobeys=self._disobeys(),
            base=self._trouble,
            has_ended=now - self._commanded >= SILENCE_S,
            clearance=self._clearance(),
        )
        before = self.report.state
        decision = self.latch.decide(situation, self.pause.reason())
        self._switch_motors(before, decision.state)
        follows = decision.state is GuardState.FOLLOWING
        self._send(*(self.limits.scaled_down(*self._wanted) if follows else _STOP))
        # The robot is held already; who else commands it is said once that has a name.
        longest_s = NAMED_AFTER_S if before is GuardState.FOLLOWING else _NAMED_AT_START_S
        is_unnamed = self._names.is_on(commanders, now, longest_s)
        is_early = decision.state is GuardState.CONTESTED and is_unnamed
        self._publish_report(self.report if is_early else decision)
        self._stepped = now

    def stop(self) -> None:
        """Stop the robot before the publisher to its base closes."""
        self._send(*_STOP)
        messages.wait_until_received([self.base.publisher])

    def _trouble_of_base(self) -> GuardState | None:
        """Return how the base does not listen to its guard alone; None if it does.

        The base is in the process that sends odometry; if no listener is, it may be any listener.
        """
        listens, own = self.base.follow_listeners(), self.get_fully_qualified_name()
        robot = cmd_vel_topics.participants(self, self._odom)
        to_guard = cmd_vel_topics.listeners(self, self.base.topic)
        everyone = cmd_vel_topics.listeners(self, self._cmd_vel)
        to_all = [one for one in everyone if one.name != own]
        found = [*to_all, *to_guard]
        base = [one for one in found if one.participant in robot]
        if any(one in to_all for one in base or found):
            return GuardState.OPEN
        is_known = base or len(found) == 1
        return None if listens and is_known else GuardState.UNCONNECTED

    def _take_messages(self) -> None:
        """Take the newest command, if it is one, and what the wheels do."""
        if message := self.cmd_vel():
            sent, wanted = message.header.stamp, velocities(message)
            # Not the begin of the step: a command that came later, while this process stalled,
            # would make all that follow look late.
            now = self.time.clock.now()
            late = self._stamps.lateness(messages.seconds_of(sent), now)
            if not all(map(math.isfinite, wanted)):
                self._commanded = -math.inf  # as silence, at once
            elif late <= LATEST_S:
                # It came after the last step, and counts as that old: this process may stall.
                self._wanted, self._commanded = wanted, self._stepped
        if message := self.wheels():
            self.obedience.measure(*velocities(message.twist.twist), self.time.now)

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
        V, _ = self.limits.scaled_down(*self._wanted)
        scan, width = self._scan, self.limits.wheel_separation
        found = lidar.clearance(scan.ranges, scan.angle_min, scan.angle_increment, V, width)
        return math.inf if found >= lidar.braking_distance(V) else found

    def _switch_motors(self, before: GuardState, state: GuardState) -> None:
        """Switch the motors: off where zeros do not or may not help, on only by a start."""
        if state in _MOTORS_OFF:
            self.motors.cut()
        elif state is not GuardState.FOLLOWING:
            self.motors.leave()
        elif before is not state:
            self.motors.give()
        self.motors.step(self.time.now)

    def _disobeys(self) -> bool:
        """Return whether the base goes on despite zero; one that listens to others may."""
        found = self.obedience.update(*self.sent, self.time.now)
        return found is Disobedience.IGNORES_ZERO and self._trouble is not GuardState.OPEN

    def _send(self, V: float, omega: float) -> None:
        self.sent = V, omega
        self.base.publish(V, omega)

    def _publish_report(self, decision: GuardDecision) -> None:
        """Publish the decision, at once if it is new; log it if it stops the robot."""
        report = replace(decision, lidar=self.options.lidar)
        if report == self.report and self.time.now - self._reported < _REPORT_EVERY_S:
            return
        was, state = self.report.state, decision.state
        is_news = was is GuardState.FOLLOWING or state in _LOGGED
        if state.stops and state is not was and is_news:
            self.warn(f'{self._name} is stopped: {decision.reason}')
        self.report, self._reported = report, self.time.now
        self.reports.publish(report_message(report, self._name, self._cmd_vel))

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

    def step() -> None:
        guard.step()
        notify('WATCHDOG=1')

    try:
        run_steps(process, guard.time, step)
    finally:
        guard.stop()


if __name__ == '__main__':
    sys.exit(main())
