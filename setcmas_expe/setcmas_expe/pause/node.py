"""Pause node: whether the robots of an experiment may move. It starts paused.

Run as `ros2 run setcmas_expe pause`; `setcmas expe` does it for you.
"""

from __future__ import annotations

import argparse
import sys
import time

from rclpy.clock import Clock, ClockType
from sensor_msgs.msg import Joy
from std_msgs.msg import Bool
from std_srvs.srv import SetBool

from setcmas_expe.lab.model import Lab
from setcmas_expe.lab.options import LabOptions
from setcmas_expe.pause.bridge_watch import BridgeWatch
from setcmas_expe.pause.console_protocol import Status, Word
from setcmas_expe.pause.console_reader import ConsoleReader
from setcmas_expe.pause.joystick import Joystick
from setcmas_expe.pause.start_requests import REACTION_S, REPEATS_WITHIN_S, StartRequests
from setcmas_expe.safety.stalls import StallDetector, time_since_boot
from setcmas_simu.fleet import topics
from setcmas_simu.reports.launcher import Launcher
from setcmas_simu.ros import qos
from setcmas_simu.ros.process import FleetNode, RosProcess, node_main

RATE_HZ = 10.0
"""Rate in Hz at which the pause state is sent."""

_TICKS_PER_MESSAGE = 2  # keys are looked at twice as often as the state is sent


class Pause(FleetNode):
    """Decides between stand and go: by joystick, keyboard and /pause, and by their absence."""

    def __init__(self, lab: Lab, keys: ConsoleReader | None, launcher: Launcher) -> None:
        """Create the node.

        Args:
            lab: Which robots there are, and which button of the joystick counts.
            keys: What comes from the terminal; None without one.
            launcher: Shows the state in the terminal.
        """
        super().__init__(topics.PAUSE_NODE)
        self.paused = True
        self.why = ''
        self._shown = (True, '')
        self._keys = keys
        self._launcher = launcher
        self._joystick = Joystick(lab.joystick_button)
        self._joystick_told = False
        self._button = lab.joystick_button
        self._joystick_topic = lab.joystick_topic
        self._ticks = 0
        self._stalls = StallDetector(lab.timeouts.pause_s, time_since_boot())
        self._requests = StartRequests(time.monotonic())
        self._repetition_told = self._haste_told = False
        self._bridge = BridgeWatch(self, lab)
        self._publisher = self.create_publisher(Bool, topics.PAUSED, qos.STATE)
        self.create_subscription(
            Bool,
            topics.FLEET_PAUSE,
            lambda message: self._request(message.data, 'by /pause'),
            qos.EVENT,
        )
        self.create_service(SetBool, '~/pause', self._answer)
        self.create_subscription(Joy, lab.joystick_topic, self._on_joy, qos.SENSOR)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(1.0 / (RATE_HZ * _TICKS_PER_MESSAGE), self._tick, clock=steady)

    def set(self, paused: bool, why: str, by_itself: bool = False) -> None:
        """Pause, or let the robots go; says so."""
        if paused and not self.paused:
            self._requests.note_pause(by_itself, time.monotonic())
        if (paused, why) != (self.paused, self.why):
            self.get_logger().info(f'paused: {why}' if paused else f'started: {why}')
        self.paused, self.why = paused, why
        self.publish()

    def wish(self, paused: bool, why: str) -> str:
        """Pause; or let the robots go, if all of them are ready; returns why not."""
        unready = '' if paused else self._unreadiness()
        if unready:
            self.get_logger().warning(f'not started: {unready}')
        else:
            self.set(paused, why)
        return unready

    def toggle(self, why: str) -> None:
        """Start if paused, else pause."""
        hasty = self._requests.hasty(time.monotonic())
        if not (hasty and self.paused):
            self._haste_told = False
            self.wish(not self.paused, why)
        elif not self._haste_told:
            self._haste_told = True
            self.get_logger().warning(f'not started: too soon; press once more ({REACTION_S:g} s)')

    def _unreadiness(self) -> str:
        """Return why robots cannot be started now; empty if they can."""
        if self._stalls.recent(time_since_boot()):
            return 'the pause node was held up, and the wish may be an old one'
        if self._keys and self._keys.stuck:
            return 'the terminal does not answer'
        return self._bridge.unreadiness()

    def publish(self) -> None:
        """Send the state."""
        self._publisher.publish(Bool(data=self.paused))

    def _request(self, paused: bool, why: str) -> str:
        """Do what a message or a service asks for; returns why not."""
        if not self._requests.repeated(paused, time.monotonic()):
            self._repetition_told = False
            return self.wish(paused, why)
        refusal = (
            'false is repeated on /pause; send it once, and none for '
            f'{REPEATS_WITHIN_S:g} s before'
        )
        if self.paused and not self._repetition_told:
            self._repetition_told = True
            self.get_logger().warning(f'not started: {refusal}')
        return refusal if self.paused else ''

    def _answer(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        refusal = self._request(request.data, 'by service')
        response.success = not refusal
        done = 'paused' if self.paused else 'started'
        response.message = f'not started: {refusal}' if refusal else done
        return response

    def _on_joy(self, message: Joy) -> None:
        if self._joystick.pressed(message.buttons, time.monotonic()):
            # Two that contradict each other look like a button that is pressed all the time.
            if self.paused and self.count_publishers(self._joystick_topic) > 1:
                self.get_logger().warning(
                    f'not started: several nodes publish {self._joystick_topic}'
                )
            else:
                self.toggle('by joystick')
        if self._joystick.missing_button and not self._joystick_told:
            self._joystick_told = True
            self.get_logger().warning(
                f'the joystick has {len(message.buttons)} buttons, counted from 0; button '
                f'{self._button} is not among them: set joystick.button in the lab file'
            )

    def _tick(self) -> None:
        now = time.monotonic()
        if self._stalls.tick(time_since_boot()) and not self.paused:
            self.set(True, 'the pause node was held up', by_itself=True)
        if self._joystick.disappeared(now):
            self.set(True, 'the joystick has disappeared', by_itself=True)
        if self._keys:
            self._serve_terminal(self._keys, now)
        if self._bridge.ending:  # a bridge that hangs just now cannot stop its robots
            self._bridge.command_zero()
        if trouble := self._bridge.trouble(now):
            self.set(True, trouble, by_itself=True)
            self._bridge.command_zero()
        if refusal := self._bridge.refusal(self.paused, now):
            self.set(True, refusal.removeprefix('paused: '), by_itself=True)
        self._ticks += 1
        if self._ticks % _TICKS_PER_MESSAGE == 0:
            self.publish()

    def _serve_terminal(self, keys: ConsoleReader, now: float) -> None:
        for word in keys.words():
            if word is Word.TOGGLE:
                self.toggle('by space bar')
            elif word is Word.PAUSE:
                self._requests.hasty(now)  # it is a press, too
                self.set(True, 'by space bar')
            elif word is Word.GO:
                self.wish(False, 'by command')
            elif word is Word.HALT:
                self._bridge.died = True
            elif word is Word.END:
                self._bridge.ending = True
                self.set(True, 'the experiment ends')
        if keys.silent(now) and not self._bridge.ending:
            self.set(True, 'the terminal does not answer', by_itself=True)
        # A bridge that hangs has no news, but that the robots are paused then is one.
        robots = self._bridge.news(unless_old=(self.paused, self.why) == self._shown)
        if robots:
            self._shown = self.paused, self.why
            self._launcher.tell(Status(self.paused, self.why, robots))


def main(argv: list[str] | None = None) -> int:
    """Serve until a signal arrives; returns the exit status."""
    parser = argparse.ArgumentParser(prog='pause', description=__doc__)
    LabOptions.add_to(parser)
    parser.add_argument(
        '--console', action='store_true', help='keys come on standard input from setcmas expe'
    )
    return node_main(parser, _serve, argv)


def _serve(process: RosProcess, args: argparse.Namespace) -> None:
    lab = LabOptions.of(args).chosen()
    keys = ConsoleReader(process.stop) if args.console else None
    node = Pause(lab, keys, process.launcher)
    process.add(node)
    try:
        process.spin()
    finally:  # whatever happens in a callback
        node.set(True, 'the pause node ends')


if __name__ == '__main__':
    sys.exit(main())
