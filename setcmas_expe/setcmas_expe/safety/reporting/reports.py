"""Reports of the bridge process: stops, rejected poses, robots that do not listen."""

from __future__ import annotations

from collections.abc import Callable

from setcmas_expe.battery import LOW_PERCENT
from setcmas_expe.mocap.arrivals import SLOWEST_HZ
from setcmas_expe.safety.cmd_vel_bridge import CmdVelBridge
from setcmas_expe.safety.decision import Decision, State
from setcmas_expe.safety.mocap_bridge import MocapBridge
from setcmas_expe.safety.reporting.stop_reports import StopReports
from setcmas_simu.fleet.fleet import robots_in_words

_REJECTED_EVERY_S = 1.0
_GRAPH_EVERY_S = 2.0
_SILENT_AFTER_S = 3.0


class BridgeReports:
    """Says each thing once, or once a second where it counts."""

    def __init__(
        self,
        warn: Callable[[str], None],
        robots: list[tuple[MocapBridge, CmdVelBridge]],
        resumes: bool,
    ) -> None:
        """Prepare.

        Args:
            warn: Shows a message to the user.
            robots: The bridges of each robot.
            resumes: Whether stopped robots go on by themselves; where not, the pause node tells.
        """
        self._warn = warn
        self._robots = robots
        self._resumes = resumes
        self._stops = StopReports(warn)
        self._first: float | None = None
        self._next_rejected = self._next_graph = 0.0
        self._unheard: list[int] | None = None
        self._told: set[tuple[str, int]] = set()
        self._pause_was_heard = False
        self._pause_is_silent = False
        self._was_paused = True

    def update(self, decisions: dict[int, Decision], pause_is_silent: bool, now: float) -> None:
        """Take what was decided at a time (s, steady) and say what is new."""
        self._first = now if self._first is None else self._first
        paused = any(decision.state is State.PAUSED for decision in decisions.values())
        if self._was_paused and not paused:
            self._tell_unguarded(
                '{} started without a cmd_vel_guard: if this computer or its network dies, '
                'nothing ends the last velocity'
            )
        self._was_paused = paused
        if not paused:
            self._stops.update({robot: self._told_here(d) for robot, d in decisions.items()}, now)
        self._tell_silence(pause_is_silent)
        if now >= self._next_rejected:
            self._next_rejected = now + _REJECTED_EVERY_S
            self._tell_rejected()
        if now >= self._next_graph:
            self._next_graph = now + _GRAPH_EVERY_S
            self._check_graph(now - self._first)

    def _told_here(self, decision: Decision) -> str:
        return '' if decision.lasting and not self._resumes else decision.reason

    def _tell_silence(self, silent: bool) -> None:
        self._pause_was_heard = self._pause_was_heard or not silent
        if self._pause_was_heard and silent != self._pause_is_silent:
            self._pause_is_silent = silent
            self._warn(
                'all robots stopped: nothing is heard of the pause node'
                if silent
                else 'the pause node is heard again'
            )

    def _tell_rejected(self) -> None:
        for mocap, _ in self._robots:
            rejected = mocap.track.rejected
            if rejected:
                reasons = ', '.join(f'{count} {reason}' for reason, count in rejected.items())
                self._warn(f'robot {mocap.robot}: poses left out: {reasons}')
                rejected.clear()

    def _check_graph(self, running_s: float) -> None:
        unheard = [bridge.robot for _, bridge in self._robots if not bridge.is_heard]
        if running_s < _SILENT_AFTER_S:  # others are still being discovered
            return
        if unheard != self._unheard:
            self._tell_unheard(unheard)
        silent = [
            bridge
            for _, bridge in self._robots
            if not bridge.guard.is_there() and not bridge.guard.doubt
        ]
        self._once(
            'guard',
            [bridge.robot for bridge in silent if not bridge.guard.is_known],
            'no cmd_vel_guard on {}; docs/lab.md tells how to install it on a robot',
        )
        self._once(
            'silent guard',
            [bridge.robot for bridge in silent if bridge.guard.is_known],
            'the cmd_vel_guard of {} is silent: is the robot off, or out of the network?',
        )
        self._once(
            'open',
            [bridge.robot for _, bridge in self._robots if bridge.guard.is_open],
            'the base of {} listens to cmd_vel itself, past its guard; docs/lab.md tells how to '
            'remap it',
        )
        for mocap, bridge in self._robots:
            if bridge.cmd_vel.mixed:
                self._once('mixed', [bridge.robot], f'{bridge.cmd_vel.mixed} ({{}})')
            if bridge.battery is not None and bridge.battery < LOW_PERCENT:
                told = f'the battery of {{}} is at {bridge.battery:.0f} %: charge it'
                self._once('battery', [bridge.robot], told)
            rate = mocap.track.arrivals.rate
            if rate < SLOWEST_HZ:
                told = f'motion capture sends {{}} only {rate:.1f} times a second'
                self._once('rate', [mocap.robot], f'{told}; let it send at {SLOWEST_HZ:g} Hz')

    def _tell_unguarded(self, message: str) -> None:
        unguarded = [bridge.robot for _, bridge in self._robots if not bridge.guard.is_there()]
        if unguarded:
            self._warn(message.format(robots_in_words(unguarded)))

    def _tell_unheard(self, unheard: list[int]) -> None:
        if unheard:
            robot = next(b for _, b in self._robots if b.robot == unheard[0])
            self._warn(
                f'nothing listens to the commands of {robots_in_words(unheard)} '
                f'({robot.topic}): they will not move; is their bringup running, in this ROS '
                'domain and namespace?'
            )
        elif self._unheard:
            self._warn('all robots listen now')
        self._unheard = unheard

    def _once(self, topic: str, robots: list[int], message: str) -> None:
        new = [robot for robot in robots if (topic, robot) not in self._told]
        self._told |= {(topic, robot) for robot in new}
        if new:
            self._warn(message.format(robots_in_words(new)))
