"""Reports of the bridge process: messages to the user, /diagnostics and /bridge_state."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node

from setcmas_expe.guard.guard_watch import diagnostic_status
from setcmas_expe.lab.lab import LOW_PERCENT
from setcmas_expe.mocap.pose_track import SLOWEST_HZ
from setcmas_expe.safety.bridge_decision import Decision, State
from setcmas_expe.safety.robot_bridges import CmdVelBridge, MocapBridge
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.ros import qos

OVER_AFTER_S = 0.5
"""How long a reason must be gone to be over: a robot at the border comes and goes."""

_REJECTED_EVERY_S = 1.0
_GRAPH_EVERY_S = 2.0
_SILENT_AFTER_S = 3.0


class StopReports:
    """Reports each stop and its reason once, and once when it is over."""

    def __init__(self, warn: Callable[[str], None]) -> None:
        self._warn = warn
        self._reported: dict[int, str] = {}
        self._gone_since: dict[int, float] = {}

    def update(self, reasons: Mapping[int, str], now: float) -> None:
        """Take the reason of each robot at a time (s); empty for those that are free."""
        started: dict[str, list[int]] = {}
        over: list[int] = []
        for robot, reason in reasons.items():
            if reason:
                self._gone_since.pop(robot, None)
                if self._reported.get(robot) != reason:
                    self._reported[robot] = reason
                    started.setdefault(reason, []).append(robot)
            elif (
                robot in self._reported
                and now - self._gone_since.setdefault(robot, now) >= OVER_AFTER_S
            ):
                del self._reported[robot], self._gone_since[robot]
                over.append(robot)
        for reason, robots in started.items():
            self._warn(f'{robots_in_words(sorted(robots))} stopped: {reason}')
        if over:
            self._warn(f'{robots_in_words(sorted(over))} free to move again')


class BridgeReports:
    """Reports each event once, or once a second where its number counts."""

    def __init__(
        self, warn: Callable[[str], None], robots: list[tuple[MocapBridge, CmdVelBridge]]
    ) -> None:
        """Report through `warn`, except lasting stops: the pause node reports these."""
        self._warn = warn
        self._robots = robots
        self._stops = StopReports(warn)
        self._first: float | None = None
        self._next_rejected = self._next_graph = 0.0
        self._silent: list[int] | None = None
        self._reported: set[tuple[str, int]] = set()
        self._pause_was_received = False
        self._pause_is_silent = False
        self._was_paused = True

    def update(self, decisions: dict[int, Decision], pause_is_silent: bool, now: float) -> None:
        """Take the decisions at a time (s, steady) and report news."""
        self._first = now if self._first is None else self._first
        paused = any(decision.state is State.PAUSED for decision in decisions.values())
        if self._was_paused and not paused:
            self._warn_unguarded()
        self._was_paused = paused
        if not paused:
            reasons = {
                robot: '' if decision.lasting else decision.reason
                for robot, decision in decisions.items()
            }
            self._stops.update(reasons, now)
        self._report_silence(pause_is_silent)
        if now >= self._next_rejected:
            self._next_rejected = now + _REJECTED_EVERY_S
            self._report_rejected()
        if now >= self._next_graph:
            self._next_graph = now + _GRAPH_EVERY_S
            self._check_graph(now - self._first)

    def _report_silence(self, silent: bool) -> None:
        self._pause_was_received = self._pause_was_received or not silent
        if self._pause_was_received and silent != self._pause_is_silent:
            self._pause_is_silent = silent
            self._warn(
                'all robots stopped: the pause node is silent'
                if silent
                else 'the pause node is back'
            )

    def _report_rejected(self) -> None:
        for mocap, _ in self._robots:
            rejected = mocap.track.rejected
            if rejected:
                reasons = ', '.join(f'{count} {reason}' for reason, count in rejected.items())
                self._warn(f'robot {mocap.robot}: poses rejected: {reasons}')
                rejected.clear()

    def _check_graph(self, running_s: float) -> None:
        if running_s < _SILENT_AFTER_S:  # discovery takes time
            return
        mixed = {one.robot: one.cmd_vel.mixed for _, one in self._robots if one.cmd_vel.mixed}
        if mixed:
            text = f'{next(iter(mixed.values()))} ({{}}); choose with --cmd-vel-type'
            self._once('mixed', list(mixed), text)
        without_listener = [
            one.robot
            for _, one in self._robots
            if not one.robot_listens and one.robot not in mixed
        ]
        if without_listener != self._silent:
            self._report_no_listener(without_listener)
        bridges = [bridge for _, bridge in self._robots]
        silent = [one for one in bridges if not one.guard.is_there() and not one.guard.doubt]
        self._once(
            'guard',
            [bridge.robot for bridge in silent if not bridge.guard.is_known],
            'no cmd_vel_guard on {}: install it (docs/lab_setup.md)',
        )
        self._once(
            'silent guard',
            [bridge.robot for bridge in silent if bridge.guard.is_known],
            'the cmd_vel_guard of {} is silent: is the robot off, or out of the network?',
        )
        self._once(
            'open',
            [bridge.robot for bridge in bridges if bridge.guard.is_open],
            'the base of {} listens to cmd_vel directly: remap it (docs/lab_setup.md)',
        )
        self._once(
            'wheels',
            [bridge.robot for bridge in bridges if bridge.has_invalid_wheels],
            'the wheel odometry of {} has velocities that are NaN or infinite: they are ignored',
        )
        for mocap, bridge in self._robots:
            if bridge.battery is not None and bridge.battery < LOW_PERCENT:
                text = f'the battery of {{}} is at {bridge.battery:.0f} %: charge it'
                self._once('battery', [bridge.robot], text)
            rate = mocap.track.arrivals.rate
            if rate < SLOWEST_HZ:
                text = f'motion capture sends {{}} at {rate:.1f} Hz: it needs {SLOWEST_HZ:g} Hz'
                self._once('rate', [mocap.robot], text)

    def _warn_unguarded(self) -> None:
        unguarded = [bridge.robot for _, bridge in self._robots if not bridge.guard.is_there()]
        if unguarded:
            self._warn(
                f'{robots_in_words(unguarded)} started without a cmd_vel_guard: if this computer '
                'or its network dies, they keep their last velocity'
            )

    def _report_no_listener(self, without_listener: list[int]) -> None:
        if without_listener:
            robot = next(b for _, b in self._robots if b.robot == without_listener[0])
            self._warn(
                f'nothing listens to the commands of {robots_in_words(without_listener)} '
                f'({robot.topic}): is the bringup running, in this ROS domain and namespace?'
            )
        elif self._silent:
            self._warn('all robots listen now')
        self._silent = without_listener

    def _once(self, topic: str, robots: list[int], message: str) -> None:
        new = [robot for robot in robots if (topic, robot) not in self._reported]
        self._reported |= {(topic, robot) for robot in new}
        if new:
            self._warn(message.format(robots_in_words(new)))


class RobotDiagnostics:
    """Publishes a status for each robot: OK, WARN (stopped) or ERROR (lost).

    /diagnostics may have other senders, such as a player of recordings; /bridge_state has one.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publishers = [
            node.create_publisher(DiagnosticArray, topics.DIAGNOSTICS, qos.STATE),
            node.create_publisher(DiagnosticArray, topics.BRIDGE_STATE, qos.STATE),
        ]

    def publish(
        self,
        robots: list[tuple[MocapBridge, CmdVelBridge]],
        decisions: dict[int, Decision],
        runaways: Collection[int],
        held: str,
        now: float,
    ) -> None:
        """Publish the decisions for the robots, and which of them do not stop.

        `held` is why the bridge itself pauses all robots; empty if it does not.
        """
        message = DiagnosticArray()
        message.header.stamp = self._node.get_clock().now().to_msg()
        message.status = [
            _status(mocap, bridge, decisions[bridge.robot], bridge.robot in runaways, held, now)
            for mocap, bridge in robots
        ]
        for publisher in self._publishers:
            publisher.publish(message)


def _status(
    mocap: MocapBridge,
    bridge: CmdVelBridge,
    decision: Decision,
    runs_away: bool,
    held: str,
    now: float,
) -> DiagnosticStatus:
    level = DiagnosticStatus.OK if decision.state is State.MOVING else DiagnosticStatus.WARN
    if decision.lost or runs_away:
        level = DiagnosticStatus.ERROR
    age = mocap.track.age(now)
    values = {
        'state': decision.state.value,
        'pose_age': f'{age:.3f}' if math.isfinite(age) else '',
        'battery': '' if bridge.battery is None else f'{bridge.battery:.0f}',
        'speed': f'{mocap.speed:.3f}',
        'runs_away': 'yes' if runs_away else '',
        'held': held,
    }
    name = topics.robot_name(bridge.robot)
    return diagnostic_status(level, name, decision.reason, bridge.topic, values)
