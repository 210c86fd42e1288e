"""Watch over the bridge process by its state; stops the robots when it is gone."""

from __future__ import annotations

import time

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node

from setcmas_ctrl.driving.fleet_pause import BY_WISH
from setcmas_expe.lab.lab import Lab
from setcmas_expe.pause.console_protocol import RobotStatus
from setcmas_expe.safety.safety_decision import State
from setcmas_simu.fleet import topics
from setcmas_simu.ros import cmd_vel_topics, qos
from setcmas_simu.ros.cmd_vel_topics import CmdVelPublisher

_SILENT_AFTER_S = 0.5  # the bridge sends five a second
_FOLLOW_EVERY_S = 2.0


class BridgeWatch:
    """Knows what the bridge says, and can command zero to its robots.

    Attributes:
        died: Set when the bridge process is known to have ended.
        ending: Set when the experiment ends: silence is no trouble any more.
        held: Why the bridge pauses all robots, whatever this node says; empty if it does not.
    """

    def __init__(self, node: Node, lab: Lab) -> None:
        """Watch through a node; publishers are ready in advance, for discovery takes time."""
        self.died = self.ending = False
        self.held = ''
        self._heard: float | None = None
        self._robots: tuple[RobotStatus, ...] = ()
        self._is_new = False
        self._next_follow = 0.0
        self._node = node
        self._sender: set[bytes] = set()
        self._topics = {robot.topic(topics.CMD_VEL) for robot in lab.robots}
        self._cmd_vels = [
            CmdVelPublisher(
                node,
                robot.number,
                robot.topic(topics.CMD_VEL),
                robot.topic(topics.ODOM),
                lab.cmd_vel_type,
                qos.ROBOT_COMMAND,
            )
            for robot in lab.robots
        ]
        node.create_subscription(DiagnosticArray, topics.BRIDGE_STATE, self._on_state, qos.STATE)

    def trouble(self, now: float, paused: bool) -> str:
        """Return why the bridge cannot be relied upon at a time (s); empty if it can.

        Args:
            now: The time.
            paused: Whether robots are paused: a bridge that is new may take over then.
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
        if self._heard is None or now - self._heard <= _SILENT_AFTER_S:
            return ''
        return 'the bridge process is silent; the pause node commands zero'

    def _conflict(self, paused: bool) -> str:
        """Return why nobody knows whether the bridge says what is heard; empty if it does."""
        senders = cmd_vel_topics.participants(self._node, topics.BRIDGE_STATE)
        if len(senders) > 1:
            return (
                f'{len(senders)} processes send {topics.BRIDGE_STATE}; is another experiment, or '
                'a bag that is played, in this ROS domain?'
            )
        if paused or not self._sender:
            self._sender = senders
        elif senders and senders != self._sender:
            return f'another bridge process than at the start sends {topics.BRIDGE_STATE}'
        return ''

    def unreadiness(self) -> str:
        """Return why robots cannot be started yet; empty if they can.

        Whoever starts them sees them start: they do not begin by themselves some time later.
        """
        silent = self._heard is None or time.monotonic() - self._heard > _SILENT_AFTER_S
        if silent or not self._robots:
            return 'nothing is heard of the bridge process'
        if conflict := self._conflict(paused=True):
            return conflict
        unready = [robot for robot in self._robots if not robot.ready]
        return '; '.join(f'{robot.name}: {robot.reason}' for robot in unready[:1])

    def command_zero(self) -> None:
        """Stop all robots."""
        for cmd_vel in self._cmd_vels:
            cmd_vel.publish(0.0, 0.0)

    def news(self, unless_old: bool) -> tuple[RobotStatus, ...]:
        """Return the states of the robots; none if they are wanted only if new, and are not."""
        news = () if unless_old and not self._is_new else self._robots
        self._is_new = False
        return news

    def _on_state(self, message: DiagnosticArray) -> None:
        # Other experiments have other robots.
        ours = [status for status in message.status if status.hardware_id in self._topics]
        if ours:
            self._heard = time.monotonic()
            self._robots = tuple(map(_robot_status, ours))
            self._is_new = True
            values = {item.key: item.value for item in ours[0].values}
            self.held = values.get('held', '').removeprefix(f'{BY_WISH}: ')


def _robot_status(status: DiagnosticStatus) -> RobotStatus:
    values = {item.key: item.value for item in status.values}
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
        ready=state is not State.PAUSED or status.message == BY_WISH,
    )
