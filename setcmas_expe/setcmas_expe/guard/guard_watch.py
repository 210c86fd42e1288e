"""Reports of a guard (guard_state), and the watch over it by another process."""

from __future__ import annotations

import enum
import math
from collections.abc import Mapping
from dataclasses import dataclass

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rclpy.node import Node

from setcmas_expe.guard.guard_decision import State
from setcmas_simu.fleet import topics
from setcmas_simu.ros import cmd_vel_topics, qos
from setcmas_simu.ros.polling import PolledTopic

SILENT_AFTER_S = 0.5
"""Silence at which a guard counts as gone, in s; it reports five times a second."""

MISSING = 'no cmd_vel_guard on it'
PAST_GUARD = 'commands it past its guard'
_SILENT = 'its cmd_vel_guard is silent'


class Power(enum.Enum):
    """Whether the guard has switched the motors of its robot on or off."""

    ON = 'on'
    OFF = 'off'
    UNKNOWN = 'unknown'


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


@dataclass(frozen=True)
class GuardReport:
    """A report of a guard.

    Attributes:
        state: What it lets its robot do.
        reason: Why the robot is stopped, for people; empty if it is not.
        private: Whether the robot's base listens to the guard alone.
        power: The motors, as far as the guard has switched them.
        source: GID of the publisher that it follows, in hexadecimal; empty if none.
    """

    state: State
    reason: str
    private: bool
    power: Power
    source: str

    @property
    def stops(self) -> bool:
        """Whether it keeps its robot stopped until a start."""
        return self.state not in (State.IDLE, State.PAUSED, State.FOLLOWING)

    def has_cut(self, before: GuardReport | None) -> bool:
        """Return whether the guard has cut the motors since a report as wheels ignore zero."""
        is_new = before is not None and before.power is not Power.OFF and self.power is Power.OFF
        return is_new and self.state not in (State.EMERGENCY, State.RIVAL)

    def message(self, name: str, topic: str) -> DiagnosticStatus:
        """Return the message of a robot by name, with the topic that its base listens to."""
        values = {
            'state': self.state.value,
            'private': 'yes' if self.private else 'no',
            'motor_power': self.power.value,
            'source': self.source,
        }
        level = DiagnosticStatus.WARN if self.stops else DiagnosticStatus.OK
        if self.state is State.EMERGENCY:
            level = DiagnosticStatus.ERROR
        return diagnostic_status(level, name, self.reason, topic, values)

    @classmethod
    def of(cls, message: DiagnosticStatus) -> GuardReport:
        """Return the report in a message; an invalid one means that the robot is held."""
        values = diagnostic_values(message)
        try:
            state, power = State(values.get('state')), Power(values.get('motor_power'))
        except ValueError:
            state, power = State.HELD, Power.UNKNOWN
        reason = message.message
        if state is State.HELD and not reason:
            reason = 'its report is invalid'
        private = values.get('private') == 'yes'
        return cls(state, reason, private, power, values.get('source', ''))


class TwiceSeen:
    """Confirms a finding by a second look: processes that start or end show up bit by bit."""

    def __init__(self) -> None:
        self._last = self._confirmed = ''

    def new(self, found: str) -> str:
        """Return an alarm, once two looks in a row have found its cause; else empty."""
        confirmed = found if found == self._last else ''
        is_new = confirmed != self._confirmed
        self._last, self._confirmed = found, confirmed
        return confirmed if is_new else ''


class GuardWatch:
    """Watches the guard of a robot by its reports.

    Attributes:
        report: Its last report; None before the first.
        intruder: Who else publishes to the base; empty if none.
        doubt: Why its reports cannot be trusted; empty if they can.
        has_cut: Set when it switches the motors off because the wheels do not obey zero.
    """

    def __init__(self, node: Node, namespace: str) -> None:
        """Listen through a node to the guard in a robot's namespace (without a slash)."""
        self.report: GuardReport | None = None
        self._node = node
        self._topic = f'/{namespace}/{topics.GUARD_STATE}'
        self._cmd_vel = f'/{namespace}/{topics.CMD_VEL}'
        self._guarded = f'/{namespace}/{topics.CMD_VEL_GUARDED}'
        self.intruder = self.doubt = ''
        self.has_cut = False
        self._intruders = TwiceSeen()
        self._received = self._now = -math.inf
        self._nb_senders = 0
        self._messages = PolledTopic(
            node, DiagnosticStatus, self._topic, self._on_report, qos.STATE
        )

    def take(self, now: float) -> None:
        """Take new reports; `now` is in s on a steady clock."""
        self._now = now
        self._messages.take()

    def look_around(self) -> set[bytes]:
        """Check who reports as the guard; return the processes that may command zero as such."""
        node = self._node
        found = cmd_vel_topics.publishers(node, self._topic)
        self._nb_senders = len(found)
        listeners = {one.participant for one in cmd_vel_topics.listeners(node, self._cmd_vel)}
        guards = cmd_vel_topics.participants(node, self._guarded) & listeners
        reporters = {one.participant for one in found}
        self.doubt = ''
        if len(found) > 1:
            self.doubt = f'{len(found)} nodes report as its guard'
        elif reporters - guards:
            self.doubt = f'{found[0].full_name} reports as its guard, but is not one'
        known = reporters if reporters and not self.doubt else guards
        past = cmd_vel_topics.strangers(node, self._guarded, known)
        self.intruder = f'{past[0]} {PAST_GUARD}' if past else ''
        if intruder := self._intruders.new(self.intruder):  # also while robots are paused
            name = self._topic.split('/')[1]
            self._node.get_logger().error(f'{name}: {intruder}: SWITCH THE ROBOT OFF')
        return reporters if self.is_open and not self.doubt else set()

    @property
    def is_open(self) -> bool:
        """Whether the base of the robot receives cmd_vel directly, past its guard."""
        return self.report is not None and not self.report.private and not self.doubt

    def is_there(self) -> bool:
        """Return whether it has reported recently."""
        return self._now - self._received <= SILENT_AFTER_S

    @property
    def is_known(self) -> bool:
        """Whether there is or was one, even if it is silent."""
        return bool(self.report or self._nb_senders)

    @property
    def recent_report(self) -> GuardReport | None:
        """Its last report; None if it is silent."""
        return self.report if self.is_there() else None

    @property
    def has_ended(self) -> bool:
        """Whether it is silent, and its base listens to it alone."""
        return self.report is not None and self.report.private and not self.is_there()

    def trouble(self, demanded: bool) -> str:
        """Return why its robot may not move; empty if it may. A guard may be demanded."""
        if self.doubt:
            return self.doubt
        if not self.is_there():
            return (_SILENT if self.is_known else MISSING) if demanded else ''
        assert self.report
        return f'its guard stops it: {self.report.reason}' if self.report.stops else ''

    def _on_report(self, message: DiagnosticStatus) -> None:
        if not self.doubt:
            report = GuardReport.of(message)
            self.has_cut |= report.has_cut(self.report)
            self.report, self._received = report, self._now
