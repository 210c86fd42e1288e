"""Diagnostics of every robot: /diagnostics for people, /bridge_state for the pause node."""

from __future__ import annotations

import math
from collections.abc import Collection

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from setcmas_expe.safety.cmd_vel_bridge import CmdVelBridge
from setcmas_expe.safety.decision import Decision, State
from setcmas_expe.safety.mocap_bridge import MocapBridge
from setcmas_simu.fleet import topics
from setcmas_simu.ros import qos


class RobotDiagnostics:
    """Publishes a status for each robot: OK, WARN (held at zero) or ERROR (lost).

    Anybody may send diagnostics, as a player of recordings does; a state has one sender.
    """

    def __init__(self, node: Node) -> None:
        """Publish through a node."""
        self._node = node
        self._publishers = (
            node.create_publisher(DiagnosticArray, topics.DIAGNOSTICS, qos.STATE),
            node.create_publisher(DiagnosticArray, topics.BRIDGE_STATE, qos.STATE),
        )

    def publish(
        self,
        robots: list[tuple[MocapBridge, CmdVelBridge]],
        decisions: dict[int, Decision],
        runaways: Collection[int],
        held: str,
        now: float,
    ) -> None:
        """Publish what was decided for the robots.

        Args:
            robots: The bridges of each robot.
            decisions: What was decided, by robot.
            runaways: Robots that do not stop.
            held: Why the bridge pauses all robots, whatever the pause node says; empty if not.
            now: Time in s on a steady clock.
        """
        message = DiagnosticArray()
        message.header.stamp = self._node.get_clock().now().to_msg()
        message.status = [
            _status(mocap, bridge, decisions[bridge.robot], bridge.robot in runaways, now)
            for mocap, bridge in robots
        ]
        for status in message.status:
            status.values.append(KeyValue(key='held', value=held))
        for publisher in self._publishers:
            publisher.publish(message)


def _status(
    mocap: MocapBridge, bridge: CmdVelBridge, decision: Decision, runs_away: bool, now: float
) -> DiagnosticStatus:
    level = DiagnosticStatus.OK if decision.state is State.MOVING else DiagnosticStatus.WARN
    age = mocap.track.age(now)
    values = {
        'state': decision.state.value,
        'pose_age': f'{age:.3f}' if math.isfinite(age) else '',
        'battery': '' if bridge.battery is None else f'{bridge.battery:.0f}',
        'speed': f'{mocap.speed:.3f}',
        'runs_away': 'yes' if runs_away else '',
    }
    return DiagnosticStatus(
        level=DiagnosticStatus.ERROR if decision.lost or runs_away else level,
        name=topics.robot_name(bridge.robot),
        message=decision.reason,
        hardware_id=bridge.topic,
        values=[KeyValue(key=key, value=value) for key, value in values.items()],
    )
