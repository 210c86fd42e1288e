"""Watch over the bridge process by its reports; stops the robots when it is gone."""

from __future__ import annotations

import time

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node

from setcmas_ctrl.experiment_pause import PauseCause
from setcmas_expe.guard.guard_watch import PAST_GUARD, diagnostic_values
from setcmas_expe.lab.lab import Lab
from setcmas_expe.pause.console import RobotStatus
from setcmas_expe.safety.bridge_decision import State
from setcmas_expe.safety.robot_bridges import robot_commands
from setcmas_simu.fleet import topics
from setcmas_simu.ros import cmd_vel_topics, qos

PAUSED = PauseCause.OPERATOR.value
_SILENT_AFTER_S = 0.5  # the bridge sends five a second
_FOLLOW_EVERY_S = 2.0


class BridgeWatch:
    """Watches the bridge, and can command zero in its place.

    Attributes:
        died: Set when the bridge process has ended.
        ending: Set when the experiment ends: then silence is expected.
        held: Why the bridge itself pauses all robots; empty if it does not.
    """

    def __init__(self, node: Node, lab: Lab) -> None:
        """Watch through a node; publishers are created early, because discovery takes time."""
        self.died = self.ending = False
        self.held = ''
        self._received: float | None = None
        self._robots: tuple[RobotStatus, ...] = ()
        self._is_new = False
        self._next_follow = 0.0
        self._node = node
        self._sender: set[bytes] = set()
        self._topics = {robot.topic(topics.CMD_VEL) for robot in lab.robots}
        self._cmd_vels = [robot_commands(node, robot, lab) for robot in lab.robots]
        node.create_subscription(DiagnosticArray, topics.BRIDGE_STATE, self._on_state, qos.STATE)

    def trouble(self, now: float, paused: bool) -> str:
        """Return why the bridge is not reliable at a time (s); empty if it is.

        While robots are paused a new bridge may take over.
        """
        if now >= self._next_follow:
            self._next_follow = now + _FOLLOW_EVERY_S
            for cmd_vel in self._cmd_vels:
                cmd_vel.follow_listeners()
        if self.died:
            return 'the bridge process has died; the pause node commands zero'
        if self.ending:
            return ''
        if conflict := self._conflict(paused):
            return conflict
        if self._received is None or now - self._received <= _SILENT_AFTER_S:
            return ''
        return 'the bridge process is silent; the pause node commands zero'

    def _conflict(self, paused: bool) -> str:
        """Return why the reports may not be the bridge's; empty if they are."""
        senders = cmd_vel_topics.participants(self._node, topics.BRIDGE_STATE)
        if len(senders) > 1:
            return (
                f'{len(senders)} processes send {topics.BRIDGE_STATE}; is another experiment or a '
                'played bag in this ROS domain?'
            )
        if paused or not self._sender:
            self._sender = senders
        elif senders and senders != self._sender:
            return f'a different process than at the start sends {topics.BRIDGE_STATE}'
        return ''

    def unreadiness(self) -> str:
        """Return why robots cannot start now; empty if they can.

        They must start at once or not at all, never by themselves some time later.
        """
        silent = self._received is None or time.monotonic() - self._received > _SILENT_AFTER_S
        if silent or not self._robots:
            return 'the bridge process is silent'
        if conflict := self._conflict(paused=True):
            return conflict
        unready = [robot for robot in self._robots if not robot.ready]
        return '; '.join(f'{robot.name}: {robot.reason}' for robot in unready[:1])

    @property
    def intruded(self) -> list[str]:
        """Names of robots that another process commands past their guards."""
        return [robot.name for robot in self._robots if PAST_GUARD in robot.reason]

    def command_zero(self) -> None:
        """Stop all robots."""
        for cmd_vel in self._cmd_vels:
            cmd_vel.publish(0.0, 0.0)

    def news(self, unless_old: bool) -> tuple[RobotStatus, ...]:
        """Return the states of the robots; empty if they are old and not wanted then."""
        news = () if unless_old and not self._is_new else self._robots
        self._is_new = False
        return news

    def _on_state(self, message: DiagnosticArray) -> None:
        # The topic may carry robots of another experiment.
        ours = [status for status in message.status if status.hardware_id in self._topics]
        if ours:
            self._received = time.monotonic()
            self._robots = tuple(map(_robot_status, ours))
            self._is_new = True
            self.held = diagnostic_values(ours[0]).get('held', '').removeprefix(f'{PAUSED}: ')


def _robot_status(status: DiagnosticStatus) -> RobotStatus:
    values = diagnostic_values(status)
    known = {one.value: one for one in State}
    state = known.get(values.get('state', ''), State.STOPPED)
    return RobotStatus(
        name=status.name,
        level=ord(status.level),
        state=state,
        reason=status.message,
        pose_age=values.get('pose_age', ''),
        battery=values.get('battery', ''),
        speed=values.get('speed', ''),
        runs_away=bool(values.get('runs_away')),
        ready=state is not State.PAUSED or status.message == PAUSED,
    )
