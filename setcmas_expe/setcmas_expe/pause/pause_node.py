"""Pause node: whether the robots of an experiment may move. It starts paused.

Run as `ros2 run setcmas_expe pause`; `setcmas expe` does it for you.
"""

from __future__ import annotations

import argparse
import sys
import time
from functools import partial

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.clock import Clock, ClockType
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from setcmas_ctrl.pause_reason import PauseCause
from setcmas_expe.bridge.machine_load import StallDetector, time_since_boot, warn_of_load
from setcmas_expe.guard.guard_decision import GuardState
from setcmas_expe.guard.guard_watch import reported
from setcmas_expe.lab.lab import Lab
from setcmas_expe.lab.lab_file import LabOptions
from setcmas_expe.pause.bridge_watch import BridgeWatch
from setcmas_expe.pause.console import Action, ConsoleReader, OperatorRequest, Status
from setcmas_expe.pause.joystick import OperatorJoystick
from setcmas_expe.pause.press_judge import (
    REACTION_S,
    RELEASES_WITHIN_S,
    Emergency,
    HeldStart,
    StartRequests,
)
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.topics import robot_topic
from setcmas_simu.reports import Launcher
from setcmas_simu.ros import qos
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.process import RosProcess, node_main, prefer_this_process

RATE_HZ = 10.0
"""Rate in Hz at which the pause state is sent."""

_TICKS_PER_MESSAGE = 2  # keys are looked at twice as often as the state is sent
_LATE_TICK_S = 0.15
_QUIET_S = 1.5  # `ros2 topic pub` without --once repeats once a second


class Pause(FleetNode):
    """Starts and pauses the robots, by joystick, terminal and /pause, and by their silence."""

    def __init__(
        self,
        lab: Lab,
        keys: ConsoleReader | None,
        launcher: Launcher,
        hold: bool = False,
        joystick: bool = False,
    ) -> None:
        """Create the node.

        Args:
            lab: The robots and the joystick's start button.
            keys: Requests from the terminal; None without it.
            launcher: Shows the state in the terminal.
            hold: Whether robots move only while a key or button is held.
            joystick: Whether `setcmas expe` reads a joystick; else joysticks only stop robots.
        """
        super().__init__(topics.PAUSE_NODE)
        self.paused = True
        self.why = ''
        self._shown: tuple[bool, str] | None = None
        self._keys = keys
        self._launcher = launcher
        self._hold = hold
        self._held = HeldStart()
        self._ticks = 0
        self._ticked = time.monotonic()
        self._was_late = False
        self._stalls = StallDetector(lab.timeouts.pause_s, time_since_boot())
        self._requests = StartRequests()
        self._emergency = Emergency()
        self._warned: dict[str, float] = {}
        self._bridge = BridgeWatch(self, lab)
        self._publisher = self.create_publisher(Bool, topics.PAUSED, qos.STATE)
        self._stopped = self.create_publisher(Bool, topics.EMERGENCY_STOPPED, qos.LATCHED)
        self._joystick = OperatorJoystick(
            self, lab, self._press, self._stop, self._once, joystick, hold
        )
        # With these, every process may stop the robots; none starts them.
        of_robots = (robot_topic(robot.number, topics.PAUSE) for robot in lab.robots)
        for topic in (topics.FLEET_PAUSE, *of_robots):
            self.create_subscription(Bool, topic, partial(self._on_pause, topic), qos.EVENT)
        for profile in qos.FROM_ANYBODY:
            self.create_subscription(Bool, topics.EMERGENCY_STOP, self._on_stop, profile)
        for robot in lab.robots:
            topic = robot.topic(topics.GUARD_STATE)
            on_guard = partial(self._on_guard, robot.number)
            self.create_subscription(DiagnosticStatus, topic, on_guard, qos.STATE)
        self.create_service(Trigger, '~/emergency_stop', self._answer_stop)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(1.0 / (RATE_HZ * _TICKS_PER_MESSAGE), self._tick, clock=steady)

    def set(
        self, paused: bool, why: str, by_itself: bool = False, may_be_load: bool = False
    ) -> None:
        """Pause or start the robots, and report it; `by_itself` means automatically.

        With `may_be_load`, something was late or silent, as on an overloaded computer.
        """
        is_stop = paused and not self.paused
        if is_stop:
            now = time.monotonic()
            self._requests.note_pause(by_itself, now)
            self._held.note_pause(now)
        if (paused, why) != (self.paused, self.why) and not self._emergency.why:
            self.get_logger().info(f'paused: {why}' if paused else f'started: {why}')
        if is_stop and may_be_load:
            warn_of_load(self.get_logger().warning)
        self.paused, self.why = paused, why
        self.publish()

    def publish(self) -> None:
        """Send the state."""
        self._publisher.publish(Bool(data=self.paused))
        self._stopped.publish(Bool(data=bool(self._emergency.why)))

    def _on_pause(self, topic: str, message: Bool) -> None:
        if message.data:
            self._pause(f'by {topic}', by_itself=True)  # not by the person who presses s
        else:
            self._once(
                f'false on {topic} starts nothing in an experiment: press s in the terminal of '
                'the experiment, or start on its joystick'
            )

    def _on_stop(self, message: Bool) -> None:
        if message.data:
            self._stop(f'by {topics.EMERGENCY_STOP}')
        else:
            self._once(f'false on {topics.EMERGENCY_STOP} releases nothing: press R twice')

    def _on_guard(self, robot: int, status: DiagnosticStatus) -> None:
        if reported(status).state is GuardState.EMERGENCY:
            self._take_over(f'held by the guard of robot {robot}')

    def _answer_stop(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._stop('by service')
        response.success, response.message = True, 'stopped'
        return response

    def _pause(self, why: str, by_itself: bool = False) -> None:
        if not self._emergency.why:
            self.set(True, why, by_itself)

    def _go(self, why: str) -> None:
        """Start the robots if all of them are ready."""
        if unready := self._unreadiness():
            self._once(f'not started: {unready}')
        else:
            self.set(False, why)

    def _start(self, why: str) -> None:
        """Take a press to start, which repeats while it is held."""
        now = time.monotonic()
        if self._hold:
            counts, hint = self._held.pressed(now), ''
        else:
            counts, hint = not self._requests.hasty(now), f'wait {REACTION_S:g} s and press again'
        if not self.paused:
            return
        if counts or self._emergency.why:
            self._go(why)
        elif hint:
            self._once(f'not started: too soon; {hint}')

    def _unreadiness(self) -> str:
        """Return why robots cannot start now; empty if they can."""
        if self._emergency.why:
            return f'stop {self._emergency.why}; R twice releases it'
        if self._stalls.recent(time_since_boot()):
            return 'the pause node stalled, so the key press may have arrived too late'
        if self._keys and self._keys.stuck:
            return 'the terminal does not answer'
        return self._bridge.unreadiness()

    def _stop(self, why: str) -> None:
        if self._emergency.stop(why):
            self._report_stop()

    def _take_over(self, why: str) -> None:
        """Take over the stop of a guard or the bridge."""
        if self._emergency.take_over(why, time.monotonic()):
            self._report_stop()

    def _report_stop(self) -> None:
        intruded = ', '.join(self._bridge.intruded)
        danger = f'SWITCH {intruded} OFF, another process drives it; ' if intruded else ''
        self.get_logger().error(
            f'STOP {self._emergency.why}: {danger}press R twice to release it; robots '
            'then stay paused'
        )
        self.set(True, f'stop {self._emergency.why}')

    def _release(self) -> None:
        if not self._emergency.why:
            self._once('there is no stop to release')
        elif self.count_publishers(topics.EMERGENCY_STOPPED) > 1:
            self._once(
                f'not released: another node publishes {topics.EMERGENCY_STOPPED}, too: end it, '
                'and press R twice'
            )
        elif self._emergency.release(time.monotonic()):
            self.set(True, 'the stop is released')
        elif self._emergency.is_half_released:
            self._once(
                f'press R again after 1 to {RELEASES_WITHIN_S:g} s to release it; robots stay '
                'paused until you start them'
            )
        else:
            self._once(
                'not released: the second R came too soon; wait 1 s and press R twice again'
            )

    def _once(self, warning: str) -> None:
        """Warn, but not again while a held key or a publisher repeats the cause."""
        now = time.monotonic()
        before, self._warned[warning] = self._warned.get(warning, -_QUIET_S), now
        if now - before >= _QUIET_S:
            self.get_logger().warning(warning)

    def _press(self, why: str) -> None:
        """Take a press of the joystick's start button; while robots move it does nothing."""
        if doubt := self._joystick.doubt:
            self._once(f'not started: {doubt}')
        else:
            self._start(why)

    def _tick(self) -> None:
        now = time.monotonic()
        if self._keys:
            self._serve_terminal(self._keys, now)
        if self._stalls.tick(time_since_boot()) and not self.paused:
            self.set(True, 'the pause node stalled', by_itself=True, may_be_load=True)
        # After a delay of this process, messages wait: they are taken before the next tick.
        late = now - self._ticked > _LATE_TICK_S and not self._was_late
        self._ticked, self._was_late = now, late
        if not late and self._joystick.disappeared(now) and not self.paused:
            why = 'the joystick has disappeared'
            self.set(True, why, by_itself=True, may_be_load=True)
        if not late and self._hold and not self.paused and self._held.released(now):
            self.set(True, 'key or button released')
        self._follow_bridge(now)
        self._ticks += 1
        if self._ticks % _TICKS_PER_MESSAGE == 0:
            self.publish()

    def _follow_bridge(self, now: float) -> None:
        if self._bridge.ending:  # in case the bridge hangs
            self._bridge.command_zero()
        if trouble := self._bridge.trouble(now):
            self.set(True, trouble, by_itself=True, may_be_load=self._bridge.is_silent(now))
            self._bridge.command_zero()
        held = self._bridge.held
        if held and held.cause is PauseCause.EMERGENCY:
            self._take_over('held by the bridge')
        elif held and not self.paused:  # until a person starts again
            self.set(True, held.text, by_itself=True)

    def _serve_terminal(self, keys: ConsoleReader, now: float) -> None:
        for request, is_late in keys.requests():
            if not is_late:
                self._obey(request)
            elif request.action is Action.START:
                self._requests.hasty(time.monotonic())  # a press, too
                self._once('not started: the key press arrived too late')
            else:
                self._once('not released: the key press arrived too late')
        if keys.silent(now) and not self._bridge.ending and not self.paused:
            why = 'the terminal does not answer'
            self.set(True, why, by_itself=True, may_be_load=True)
        # A hung bridge has no news, but the pause that follows is.
        robots = self._bridge.news(unless_old=(self.paused, self.why) == self._shown)
        if robots:
            self._shown = self.paused, self.why
            status = Status(self.paused, bool(self._emergency.why), self.why, robots)
            self._launcher.report(status)

    def _obey(self, request: OperatorRequest) -> None:
        action = request.action
        if action is Action.HALT:
            self._bridge.died = True
        elif action is Action.END:
            self._bridge.ending = True
            self.set(True, 'the experiment ends')
        elif action is Action.RELEASE:
            self._release()
        elif action is not Action.ALIVE:
            {
                Action.PAUSE: self._pause,
                Action.START: self._start,
                Action.GO: self._go,
                Action.EMERGENCY: self._stop,
            }[action](request.by)


def main(argv: list[str] | None = None) -> int:
    """Serve until a signal arrives; return the exit status."""
    parser = argparse.ArgumentParser(prog='pause', description=__doc__)
    LabOptions.add_to(parser)
    parser.add_argument(
        '--console', action='store_true', help='keys come on standard input from setcmas expe'
    )
    parser.add_argument(
        '--hold', action='store_true', help='robots move only while a key or button is held'
    )
    parser.add_argument(
        '--joystick', action='store_true', help='there is a joystick, which may start robots'
    )
    prefer_this_process()
    return node_main(parser, _serve, argv)


def _serve(process: RosProcess, args: argparse.Namespace) -> None:
    lab = LabOptions.of(args).chosen()
    keys = ConsoleReader(process.stop) if args.console else None
    node = Pause(lab, keys, process.launcher, args.hold, args.joystick)
    process.add(node)
    try:
        process.spin()
    finally:  # whatever happens in a callback
        node.set(True, node.why if node.paused else 'the pause node ends')


if __name__ == '__main__':
    sys.exit(main())
