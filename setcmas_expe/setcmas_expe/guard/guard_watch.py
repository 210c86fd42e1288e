"""Reports of a guard (guard_state), and the watch over it by another process."""

from __future__ import annotations

import math
from collections.abc import Mapping

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rclpy.node import Node
from rclpy.qos import QoSProfile

from setcmas_expe.guard.guard_decision import GuardDecision, GuardState
from setcmas_simu.fleet import topics
from setcmas_simu.ros.polling import PolledTopic

SILENT_AFTER_S = 0.5
"""Silence at which a guard counts as gone, in s; it reports five times a second."""

_UNREAD = 5  # reports that may wait: one of deaf wheels holds for a moment, until motors are off
_YES, _NO = 'yes', 'no'
_MISSING = 'no cmd_vel_guard on it'
_SILENT = 'its cmd_vel_guard is silent'
_SEVERAL = '{} nodes report as its guard'
_NO_LIDAR = 'its guard watches no lidar: start it with --lidar'


def diagnostic_status(
    level: bytes, name: str, message: str, topic: str, values: Mapping[str, str]
) -> DiagnosticStatus:
    """Return a status with key-value pairs; its hardware ID is the robot's topic."""
    pairs = [KeyValue(key=key, value=value) for key, value in values.items()]
    return DiagnosticStatus(
        level=level, name=name, message=message, hardware_id=topic, values=pairs
    )


def diagnostic_values(status: DiagnosticStatus) -> dict[str, str]:
    """Return the key-value pairs of a status."""
    return {item.key: item.value for item in status.values}


def report_message(report: GuardDecision, name: str, topic: str) -> DiagnosticStatus:
    """Return a guard's report on a robot by name, with the topic of its commands."""
    level = DiagnosticStatus.WARN if report.state.stops else DiagnosticStatus.OK
    if report.state is GuardState.EMERGENCY:
        level = DiagnosticStatus.ERROR
    values = {'state': report.state.value, 'lidar': _YES if report.lidar else _NO}
    return diagnostic_status(level, name, report.reason, topic, values)


def reported(message: DiagnosticStatus) -> GuardDecision:
    """Return what a guard has reported; an invalid report means that the robot is held."""
    values = diagnostic_values(message)
    try:
        state = GuardState(values.get('state'))
    except ValueError:
        return GuardDecision(GuardState.HELD, 'its report is invalid')
    return GuardDecision(state, message.message, values.get('lidar') == _YES)


class GuardWatch:
    """Watches the guard of a robot by its reports.

    Attributes:
        report: Its last report; None before the first.
        found_deaf: Whether one of the reports that were taken last has named deaf wheels.
    """

    def __init__(self, node: Node, namespace: str) -> None:
        """Listen through a node to the guard in a robot's namespace (without a slash)."""
        self.report: GuardDecision | None = None
        self.found_deaf = False
        self._node = node
        self._name = namespace
        self._topic = f'/{namespace}/{topics.GUARD_STATE}'
        self._received = self._now = -math.inf
        self._nb_senders = 0
        self._messages = PolledTopic(
            node, DiagnosticStatus, self._topic, self._on_report, QoSProfile(depth=_UNREAD)
        )

    def take(self, now: float) -> None:
        """Take new reports; `now` is in s on a steady clock."""
        self._now, self.found_deaf = now, False
        self._messages.take()

    def look_around(self) -> None:
        """Count who reports as the guard."""
        self._nb_senders = self._node.count_publishers(self._topic)

    @property
    def intruder(self) -> str:
        """Nodes that also publish to the base, as the guard reports; empty if there are none."""
        report = self.report
        return report.reason if report and report.state is GuardState.INTRUDED else ''

    @property
    def doubt(self) -> str:
        """Why its reports cannot be trusted; empty if they can."""
        return _SEVERAL.format(self._nb_senders) if self._nb_senders > 1 else ''

    def is_there(self) -> bool:
        """Return whether it has reported recently."""
        return self._now - self._received <= SILENT_AFTER_S

    @property
    def has_ended(self) -> bool:
        """Whether it has fallen silent."""
        return self.report is not None and not self.is_there()

    def trouble(self, demanded: bool, lidar: bool = False) -> str:
        """Return why its robot may not move; empty if it may.

        A guard may be demanded, and that it watches the robot's lidar.
        """
        if self.doubt:
            return self.doubt
        if not self.is_there():
            is_known = self.report or self._nb_senders
            return (_SILENT if is_known else _MISSING) if demanded else ''
        assert self.report
        if self.report.state.stops:
            return f'its guard stops it: {self.report.reason}'
        return _NO_LIDAR if lidar and not self.report.lidar else ''

    def _on_report(self, message: DiagnosticStatus) -> None:
        if self.doubt:
            return
        report, before = reported(message), self.intruder
        self.report, self._received = report, self._now
        self.found_deaf |= report.state is GuardState.DEAF
        if self.intruder and not before:  # also while robots are paused
            self._node.get_logger().error(f'{self._name}: {self.intruder}: SWITCH THE ROBOT OFF')
