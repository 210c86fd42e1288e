"""Guard on a robot's own computer: passes commands on to its base, or stops it.

A TurtleBot3 keeps its last velocity when its commander or the network dies. Where its base
listens to the guard's topic (cmd_vel_guarded), the guard decides; where it listens to cmd_vel
directly, the guard commands zero in between, and can switch the motors off.

Run as `ros2 run setcmas_expe cmd_vel_guard --ros-args -r __ns:=/tb3_1`.
"""

from __future__ import annotations

import argparse
import contextlib
import math
import os
import socket
import sys
import time
from dataclasses import dataclass

from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.duration import Duration
from rclpy.publisher import Publisher

from setcmas_ctrl.experiment_pause import EmergencyWatch, PauseWatch
from setcmas_expe.guard.guard_commands import SILENCE_S, Commands, StopOnSilence, accelerated
from setcmas_expe.guard.guard_decision import Situation, Source, StartLatch, State
from setcmas_expe.guard.guard_watch import GuardReport, Power
from setcmas_expe.guard.motor_power import MotorPower
from setcmas_expe.guard.obedience import IGNORES_ZERO, Obedience
from setcmas_expe.guard.surroundings import Base, Surroundings
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.topics import AUTO, CMD_VEL_TYPES
from setcmas_simu.options.group import Options, option
from setcmas_simu.options.kinds import DURATION, Number, OneOf
from setcmas_simu.robots.model import LIMITS, limits_named
from setcmas_simu.ros import qos
from setcmas_simu.ros.cmd_vel_topics import TYPES, command, filled, velocities
from setcmas_simu.ros.polling import PolledServices, PolledTopic
from setcmas_simu.ros.process import (
    FleetNode,
    RosProcess,
    node_main,
    prefer_this_process,
)
from setcmas_simu.ros.step_loop import StepLoop

ACCEL = 2.5
"""Default acceleration of a wheel in m/s^2. ROBOTIS' navigation stack plans a Burger with 3.0
and brakes it with 2.5 (turtlebot3_navigation2, param/jazzy/burger.yaml)."""


@dataclass(frozen=True, kw_only=True)
class GuardOptions(Options):
    """What a guard receives, and what it passes on."""

    cmd_vel_type: str = option(
        OneOf((AUTO, *CMD_VEL_TYPES)),
        'message type of cmd_vel',
        default=AUTO,
        default_text=f'{CMD_VEL_TYPES[0]}, or that of a base that listens directly',
    )
    silence: float = option(
        DURATION, 'stop the robot after this long without a command', default=SILENCE_S
    )
    limits: str = option(OneOf(tuple(LIMITS)), 'speed limits of the robot', default='burger')
    accel: float = option(
        Number(above=0, unit='m/s^2', finite=True),
        'largest acceleration of a wheel',
        default=ACCEL,
    )


def feed_watchdog() -> None:
    """Notify systemd that this service is alive (sd_notify(3)), if systemd started it."""
    address = os.environ.get('NOTIFY_SOCKET', '')
    if not address:
        return
    where = f'\0{address[1:]}' if address.startswith('@') else address
    kind = socket.SOCK_DGRAM | socket.SOCK_NONBLOCK
    # An error here is no reason to stop guarding the robot.
    with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, kind) as systemd:
        systemd.sendto(b'WATCHDOG=1', where)


RATE_HZ = 20.0
"""Rate of steps in Hz, while a process commands the robot."""

IDLE_RATE_HZ = 10.0
"""Rate of steps in Hz otherwise."""

FIGHT_RATE_HZ = 200.0
"""Rate of steps in Hz while an intruder drives the base: the base obeys the last command."""

_REPORT_EVERY_S = 0.2
_LOOK_EVERY_S = 0.5
_LONGEST_STEP_S = 0.1
_LAST_ZERO_S = 0.3
_FIGHTS_S = 0.5
_STOP = (0.0, 0.0)
_DEFENDED = (State.EMERGENCY, State.RIVAL)


class CmdVelGuard(FleetNode):
    """Decides what reaches the wheels of one robot; it is stepped and needs no executor.

    Its namespace is the robot's; the fleet's topics are in the root.
    """

    fleet_namespace = ''

    def __init__(
        self, options: GuardOptions | None = None, namespace: str | None = None, now: float = 0.0
    ) -> None:
        """Create the node in the robot's namespace, by default that of `--ros-args`.

        `now` is in s on a steady clock.
        """
        super().__init__(topics.CMD_VEL_GUARD_NODE, namespace=namespace)
        self._requests = PolledServices(self)
        self._options = options = options or GuardOptions()
        self._limits = limits_named(options.limits)
        self._surroundings = Surroundings(self)
        self._source = Source()
        self._commands = Commands(options.silence)
        self._emergency = EmergencyWatch(self)
        self._power = MotorPower(self)
        self._obedience = Obedience(self._limits)
        self._wheels = PolledTopic(self, Odometry, topics.ODOM, self._on_wheels, qos.SENSOR)
        self._pause = PauseWatch(self, latches=True)
        self._latch = StartLatch()
        self._report = GuardReport(State.IDLE, '', False, Power.UNKNOWN, '')
        self._reports = self.create_publisher(DiagnosticStatus, topics.GUARD_STATE, qos.STATE)
        self._sent = _STOP
        self._fights_until = -math.inf
        self._now = self._stepped = self._looked = self._reported = now - _LOOK_EVERY_S
        self._base = Base()
        self._use(self._base, now)

    def step(self, now: float) -> None:
        """Decide on new messages and command the base; `now` is in s on a steady clock."""
        if now - self._looked >= _LOOK_EVERY_S:
            self._looked = now
            if (base := self._surroundings.base()) != self._base:
                self.stop()
                self._cmd_vel.close()
                for publisher in self._to_base:
                    self.destroy_publisher(publisher)
                self._use(base, now)
                self._pause.latch('its base listens to another topic than before')
        self._now = now
        self._requests.take()
        self._cmd_vel.take()
        self._wheels.take()
        before, latch = self._report.state, self._latch
        conflict = self._surroundings.impostor or self._conflict(latch.is_free)
        situation = Situation(
            emergency=self._emergency.take(),
            intruder=self._surroundings.intruder(),
            conflict=conflict,
            base_listens=self._base.is_there,
            is_commanded=bool(self._source.pinned),
            has_ended=self._has_ended(now),
            ending=self._commands.trouble,
        )
        if why := latch.reason_to_wait(situation):
            self._pause.latch(why)
        state, reason = latch.decide(situation, self._pause.reason())
        if situation.intruder:
            self._fights_until = now + _FIGHTS_S
        self._switch(situation, before, state)
        self._power.step(now)
        self._command(state, now)
        self._publish_report(state, reason, now)
        self._stepped = now

    @property
    def period(self) -> float:
        """Time in s to the next step, longer while nothing commands the robot."""
        if self._now < self._fights_until:
            return 1.0 / FIGHT_RATE_HZ
        return 1.0 / (IDLE_RATE_HZ if self._report.state is State.IDLE else RATE_HZ)

    def stop(self) -> None:
        """Stop the robot before the publishers to its base close."""
        self._publish(*_STOP)
        for publisher in self._to_base:
            publisher.wait_for_all_acked(Duration(seconds=_LAST_ZERO_S))

    def _conflict(self, is_free: bool) -> str:
        """Return why the guard must follow no process; empty if it may."""
        pinned, operator = self._source.pinned, self._surroundings.operator()
        conflict = self._source.conflict(self._surroundings.commanders(), operator, is_free)
        if conflict or self._source.pinned != pinned:
            self._commands.forget()  # their stamps may be of another clock
        if not (conflict and pinned):
            return conflict
        return self._surroundings.stranger([pinned, operator or b'']) or conflict

    def _use(self, base: Base, now: float) -> None:
        """Publish to the base on its topics, with its type of message."""
        self._base = base
        chosen = self._options.cmd_vel_type
        kind = chosen if chosen != AUTO else base.kind if base.is_open else CMD_VEL_TYPES[0]
        self._cmd_vel: PolledTopic = PolledTopic(
            self, TYPES[kind], topics.CMD_VEL, self._on_cmd_vel, qos.COMMAND
        )
        # A base that only seems to listen to cmd_vel gets zeros on the guard's topic, too.
        names = [topics.CMD_VEL_GUARDED, *([topics.CMD_VEL] if base.is_open else [])]
        self._to_base: list[Publisher] = [
            self.create_publisher(TYPES[base.kind], topic, qos.COMMAND) for topic in names
        ]
        self._frame = f'{self.get_namespace().strip("/")}/base_footprint'
        self._commands.forget()
        # The robot may be moving although its commander is dead.
        self._silence = StopOnSilence(now, self._options.silence)
        if base.is_there:
            way = 'also listens' if base.is_open else f'listens to {topics.CMD_VEL_GUARDED} alone'
            self.get_logger().info(
                f'guarding {self._surroundings.cmd_vel}: the base {way} ({base.kind})'
            )

    def _has_ended(self, now: float) -> bool:
        """Return whether there is no command to follow."""
        if self._base.is_open:
            return self._silence.must_stop(now)
        return self._commands.newest(now) is None

    def _switch(self, situation: Situation, before: State, state: State) -> None:
        """Switch the motors: off where zeros do not or may not help, on only by a start."""
        open_rival = situation.conflict and self._base.is_open
        disobeys = self._disobeys()
        if disobeys and not self._power.is_cut:
            name = self.get_namespace().strip('/')
            self.get_logger().warning(f'{name} does not obey zero: its motors are switched off')
        if state is State.EMERGENCY or situation.intruder or open_rival or disobeys:
            self._power.cut()
        elif state is State.FOLLOWING and before is not state:
            self._power.give()
        elif state is not State.FOLLOWING:
            self._power.leave()

    def _disobeys(self) -> bool:
        """Return whether the base goes on despite zero, whoever commands it."""
        is_open = self._base.is_open
        commanded = self._silence.commanded if is_open else self._sent
        ignores = self._obedience.update(*commanded, self._now) == IGNORES_ZERO
        # Between experiments a person may push an open base, and then drive it without a start.
        return ignores and not (is_open and self._obedience.came_to_rest)

    def _command(self, state: State, now: float) -> None:
        if self._base.is_open:
            if self._silence.must_stop(now) or state in _DEFENDED:
                self._publish(*_STOP)
            return
        wanted = self._commands.newest(now) if state is State.FOLLOWING else None
        gain = self._options.accel * min(now - self._stepped, _LONGEST_STEP_S)
        self._sent = accelerated(wanted, self._sent, self._limits, gain) if wanted else _STOP
        self._publish(*self._sent)

    def _publish(self, V: float, omega: float) -> None:
        for publisher in self._to_base:
            publisher.publish(filled(command(self._base.kind, self._frame), V, omega))

    def _publish_report(self, state: State, reason: str, now: float) -> None:
        """Publish the state, at once if it is new; log it if it stops the robot."""
        private = self._base.is_there and not self._base.is_open
        source = self._source.pinned.hex()
        report = GuardReport(state, reason, private, self._power.power, source)
        if report == self._report and now - self._reported < _REPORT_EVERY_S:
            return
        name = self.get_namespace().strip('/')
        was = self._report.state
        loud = state in _DEFENDED or was is State.FOLLOWING
        if report.stops and state is not was and loud:
            self.get_logger().warning(f'{name} is stopped: {reason}')
        self._report, self._reported = report, now
        self._reports.publish(report.message(name, self._surroundings.cmd_vel))

    def _on_wheels(self, message: Odometry) -> None:
        V, omega = message.twist.twist.linear.x, message.twist.twist.angular.z
        if math.isfinite(V) and math.isfinite(omega):
            self._obedience.measure(V, omega, self._now)

    def _on_cmd_vel(self, message: Twist | TwistStamped) -> None:
        V, omega = velocities(message)
        stamp = 0.0
        if isinstance(message, TwistStamped):
            stamp = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
        # Not the time of the step: after a stall, new commands would seem late, and old ones new.
        age = max(0.0, 1e-9 * (time.time_ns() - self._cmd_vel.received_ns))
        self._commands.receive(V, omega, stamp, time.monotonic() - age)
        self._silence.receive(V, omega, self._now)
        if self._base.is_open and self._report.state in _DEFENDED and (V, omega) != _STOP:
            self._fights_until = self._now + _FIGHTS_S


def main(argv: list[str] | None = None) -> int:
    """Guard until a signal arrives; return the exit status."""
    parser = argparse.ArgumentParser(prog='cmd_vel_guard', description=__doc__)
    GuardOptions.add_to(parser)
    prefer_this_process()
    return node_main(parser, _guard, argv)


def _guard(process: RosProcess, args: argparse.Namespace) -> None:
    guard = CmdVelGuard(GuardOptions.of(args), now=time.monotonic())

    def step(now: float) -> None:
        guard.step(now)
        feed_watchdog()
        loop.period = guard.period

    loop = StepLoop(process, guard.period, step)
    try:
        loop.run()
    finally:
        guard.stop()


if __name__ == '__main__':
    sys.exit(main())
