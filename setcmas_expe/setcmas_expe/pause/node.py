"""Pause node: whether the robots of an experiment may move. It starts paused."""

from __future__ import annotations

import time

from rclpy.clock import Clock, ClockType
from std_msgs.msg import Bool

from setcmas_ctrl.driving.fleet_pause import STOPPED
from setcmas_expe.lab.lab import Lab
from setcmas_expe.pause.bridge_watch import BridgeWatch
from setcmas_expe.pause.console_protocol import Status, Wish, Word
from setcmas_expe.pause.console_reader import ConsoleReader
from setcmas_expe.pause.emergency import RELEASES_WITHIN_S, Emergency
from setcmas_expe.pause.operator_joystick import OperatorJoystick
from setcmas_expe.pause.public_stops import PublicStops, Stops
from setcmas_expe.pause.start_requests import REACTION_S, HeldStart, StartRequests
from setcmas_expe.safety.stalls import StallDetector, time_since_boot
from setcmas_simu.fleet import topics
from setcmas_simu.reports.launcher import Launcher
from setcmas_simu.ros import cmd_vel_topics, qos
from setcmas_simu.ros.process import FleetNode

RATE_HZ = 10.0
"""Rate in Hz at which the pause state is sent."""

_TICKS_PER_MESSAGE = 2  # keys are looked at twice as often as the state is sent
_QUIET_S = 1.5  # `ros2 topic pub` without --once repeats once a second


class Pause(FleetNode):
    """Decides between stand and go: by joystick, terminal and /pause, and by their absence."""

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
            lab: Which robots there are, and which button of the joystick counts.
            keys: What comes from the terminal; None without one.
            launcher: Shows the state in the terminal.
            hold: Whether robots move only while a key or a button is held.
            joystick: Whether there is an operator's joystick; without, one can only stop robots.
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
        self._stalls = StallDetector(lab.timeouts.pause_s, time_since_boot())
        self._requests = StartRequests()
        self._emergency = Emergency()
        self._told: dict[str, float] = {}
        self._bridge = BridgeWatch(self, lab)
        self._publisher = self.create_publisher(Bool, topics.PAUSED, qos.STATE)
        self._stopped = self.create_publisher(Bool, topics.EMERGENCY_STOPPED, qos.LATCHED)
        stops = Stops(self._pause, self._stop, self._take_over, self._once)
        PublicStops(self, lab, stops)
        self._joystick = OperatorJoystick(self, lab, stops, self._press, joystick, hold)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(1.0 / (RATE_HZ * _TICKS_PER_MESSAGE), self._tick, clock=steady)

    def set(self, paused: bool, why: str, by_itself: bool = False) -> None:
        """Pause, or let the robots go; says so."""
        if paused and not self.paused:
            now = time.monotonic()
            self._requests.note_pause(by_itself, now)
            self._held.note_pause(now)
        if (paused, why) != (self.paused, self.why) and not self._emergency.why:
            self.get_logger().info(f'paused: {why}' if paused else f'started: {why}')
        self.paused, self.why = paused, why
        self.publish()

    def publish(self) -> None:
        """Send the state."""
        self._publisher.publish(Bool(data=self.paused))
        self._stopped.publish(Bool(data=bool(self._emergency.why)))

    def _pause(self, why: str) -> None:
        if not self._emergency.why:  # that says more
            self.set(True, why)

    def _go(self, why: str) -> None:
        """Let the robots go, if all of them are ready."""
        if unready := self._unreadiness():
            self._once(f'not started: {unready}')
        else:
            self.set(False, why)

    def _start(self, why: str) -> None:
        """Take a press that is to start, and comes again while it is held."""
        now = time.monotonic()
        if self._hold:
            counts, hint = self._held.pressed(now), ''
        else:
            counts, hint = not self._requests.hasty(now), f'press once more ({REACTION_S:g} s)'
        if not self.paused:
            return
        if counts or self._emergency.why:
            self._go(why)
        elif hint:
            self._once(f'not started: too soon; {hint}')

    def _unreadiness(self) -> str:
        """Return why robots cannot be started now; empty if they can."""
        if self._emergency.why:
            return f'{STOPPED} {self._emergency.why}; R twice releases it'
        if self._stalls.recent(time_since_boot()):
            return 'the pause node was held up, and the wish may be an old one'
        if self._keys and self._keys.stuck:
            return 'the terminal does not answer'
        return self._bridge.unreadiness()

    def _stop(self, why: str) -> None:
        """Take an emergency stop."""
        if self._emergency.stop(why):
            self._tell_stop()

    def _take_over(self, why: str) -> None:
        """Make an emergency stop one's own that somebody holds."""
        if self._emergency.take_over(why, time.monotonic()):
            self._tell_stop()

    def _tell_stop(self) -> None:
        self.get_logger().error(
            f'EMERGENCY STOP {self._emergency.why}: robots stand until R is pressed twice, '
            'and stay paused then'
        )
        self.set(True, f'{STOPPED} {self._emergency.why}')

    def _release(self) -> None:
        if not self._emergency.why:
            self._once('there is no emergency stop to release')
        elif strangers := self._other_holders():
            self._once(
                f'not released: {strangers[0]} publishes {topics.EMERGENCY_STOPPED} too, and '
                'guards believe nobody then: end it, and press R twice'
            )
        elif self._emergency.release(time.monotonic()):
            self.set(True, 'the emergency stop is released')
        else:
            self._once(
                f'R again after 1 to {RELEASES_WITHIN_S:g} s releases it: guards let go and '
                'motors get power; robots stay paused until you start them'
            )

    def _other_holders(self) -> list[str]:
        own = {cmd_vel_topics.own_participant(self)}
        return cmd_vel_topics.strangers(self, topics.EMERGENCY_STOPPED, own)

    def _once(self, warning: str) -> None:
        """Say something that a key that is held down, or a publisher, brings up all the time."""
        now = time.monotonic()
        before, self._told[warning] = self._told.get(warning, -_QUIET_S), now
        if now - before >= _QUIET_S:
            self.get_logger().warning(warning)

    def _press(self, why: str) -> None:
        """Take a press of the button that starts robots, and pauses them when they move."""
        if not self.paused and not self._hold:
            self._requests.hasty(time.monotonic())  # it is a press, too
            self._pause(why)
        elif doubt := self._joystick.doubt:
            self._once(f'not started: {doubt}')
        else:
            self._start(why)

    def _tick(self) -> None:
        now = time.monotonic()
        if self._keys:
            self._serve_terminal(self._keys, now)
        if self._stalls.tick(time_since_boot()) and not self.paused:
            self.set(True, 'the pause node was held up', by_itself=True)
        if self._joystick.disappeared() and not self.paused:
            self.set(True, 'the joystick has disappeared', by_itself=True)
        if self._hold and not self.paused and self._held.released(now):
            self.set(True, 'nothing is held any more')
        self._follow_bridge(now)
        self._ticks += 1
        if self._ticks % _TICKS_PER_MESSAGE == 0:
            self.publish()

    def _follow_bridge(self, now: float) -> None:
        if self._bridge.ending:  # a bridge that hangs just now cannot stop its robots
            self._bridge.command_zero()
        if trouble := self._bridge.trouble(now, self.paused):
            self.set(True, trouble, by_itself=True)
            self._bridge.command_zero()
        if self._bridge.held == STOPPED:
            self._take_over('that the bridge holds')
        elif self._bridge.held and not self.paused:  # it ends only when somebody starts again
            self.set(True, self._bridge.held, by_itself=True)

    def _serve_terminal(self, keys: ConsoleReader, now: float) -> None:
        for wish in keys.wishes():
            self._obey(wish)
        for word in keys.late():
            refused = 'not released'
            if word is Word.START:
                refused = 'not started'
                self._requests.hasty(time.monotonic())  # it is a press, too
            self._once(
                f'{refused}: the terminal or the page was held up, and the press may be old'
            )
        if keys.silent(now) and not self._bridge.ending and not self.paused:
            self.set(True, 'the terminal does not answer', by_itself=True)
        # A bridge that hangs has no news, but that the robots are paused then is one.
        robots = self._bridge.news(unless_old=(self.paused, self.why) == self._shown)
        if robots:
            self._shown = self.paused, self.why
            status = Status(self.paused, bool(self._emergency.why), self.why, robots)
            self._launcher.report(status)

    def _obey(self, wish: Wish) -> None:
        if wish.word is Word.PAUSE:
            self._pause(wish.by)
        elif wish.word is Word.START:
            self._start(wish.by)
        elif wish.word is Word.GO:
            self._go(wish.by)
        elif wish.word is Word.EMERGENCY:
            self._stop(wish.by)
        elif wish.word is Word.RELEASE:
            self._release()
        elif wish.word is Word.HALT:
            self._bridge.died = True
        elif wish.word is Word.END:
            self._bridge.ending = True
            self.set(True, 'the experiment ends')
