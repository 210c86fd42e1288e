"""Watch over the bridges by their reports; commands zero when they are gone."""

from __future__ import annotations

import math
import time
from functools import partial

from diagnostic_msgs.msg import DiagnosticStatus

from setcmas_ctrl.pause_reason import PauseReason
from setcmas_expe.bridge.bridge_report import BridgeReport
from setcmas_expe.cmd_vel_bridge import robot_commands
from setcmas_expe.guard.guard_watch import diagnostic_values
from setcmas_expe.lab.lab import Lab
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.topics import robot_topic
from setcmas_simu.ros import qos
from setcmas_simu.ros.fleet_node import FleetNode

_SILENT_AFTER_S = 0.5  # a bridge sends five a second
_FOLLOW_EVERY_S = 2.0


class BridgeWatch:
    """Watches the bridges of a lab's robots, and can command zero in their place.

    Attributes:
        died: Set when their process has ended.
        ending: Set when the experiment ends: then silence is expected.
    """

    def __init__(self, node: FleetNode, lab: Lab) -> None:
        """Watch through a node; publishers are created early, because discovery takes time."""
        self.died = self.ending = False
        self._received = {robot.number: -math.inf for robot in lab.robots}
        self._reports: dict[int, BridgeReport] = {}
        self._is_new = False
        self._next_follow = 0.0
        self._node = node
        self._cmd_vels = [robot_commands(node, robot) for robot in lab.robots]
        for robot in self._received:
            topic = robot_topic(robot, topics.BRIDGE_STATE)
            callback = partial(self._on_state, robot)
            node.create_subscription(DiagnosticStatus, topic, callback, qos.STATE)

    @property
    def held(self) -> PauseReason | None:
        """Why the bridges themselves pause all robots; None if they do not."""
        return next((one.held for one in self._reports.values() if one.held), None)

    @property
    def intruded(self) -> list[str]:
        """Names of robots that another process commands past their guards."""
        return [one.name for one in self._reports.values() if one.is_intruded]

    def trouble(self, now: float) -> str:
        """Return why the bridges are not reliable at a time (s); empty if they are."""
        if now >= self._next_follow:
            self._next_follow = now + _FOLLOW_EVERY_S
            for cmd_vel in self._cmd_vels:
                cmd_vel.follow_listeners()
        if self.died:
            return 'the bridge process has died; the pause node commands zero'
        if self.ending:
            return ''
        if self._reports and self.is_silent(now):
            return self._conflict() or 'the bridge process is silent; the pause node commands zero'
        return self._conflict()

    def is_silent(self, now: float) -> bool:
        """Return whether a bridge sends no reports at a time (s)."""
        return any(now - received > _SILENT_AFTER_S for received in self._received.values())

    def unreadiness(self) -> str:
        """Return why robots cannot start now; empty if they can.

        They must start at once or not at all, never by themselves some time later.
        """
        if self.died or self.ending:
            return 'the experiment ends'
        if self.is_silent(time.monotonic()):
            return 'the bridge process is silent'
        if conflict := self._conflict():
            return conflict
        unready = (one for one in self._reports.values() if not one.ready)
        return next((f'{one.name}: {one.reason}' for one in unready), '')

    def command_zero(self) -> None:
        """Stop all robots."""
        for cmd_vel in self._cmd_vels:
            cmd_vel.publish(0.0, 0.0)

    def news(self, unless_old: bool) -> tuple[BridgeReport, ...]:
        """Return the states of the robots; empty if they are old and not wanted then."""
        if len(self._reports) < len(self._received) or (unless_old and not self._is_new):
            return ()
        self._is_new = False
        return tuple(report for _, report in sorted(self._reports.items()))

    def _conflict(self) -> str:
        """Return why the reports may not be the bridges'; empty if they are."""
        for robot in self._received:
            topic = robot_topic(robot, topics.BRIDGE_STATE)
            if (senders := self._node.count_publishers(topic)) > 1:
                return f'{senders} nodes send {topic}; is another experiment in this ROS domain?'
        return ''

    def _on_state(self, robot: int, message: DiagnosticStatus) -> None:
        level, values = ord(message.level), diagnostic_values(message)
        self._reports[robot] = BridgeReport.read(message.name, level, message.message, values)
        self._received[robot] = time.monotonic()
        self._is_new = True
