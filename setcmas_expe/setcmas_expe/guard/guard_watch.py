"""Reports of a guard (guard_state), and the watch over it from another process."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rclpy.node import Node

from setcmas_expe.guard.guard_decision import State
from setcmas_simu.fleet import topics
from setcmas_simu.ros import cmd_vel_topics, qos
from setcmas_simu.ros.polling import PolledTopic


class Power(enum.Enum):
    """Whether a guard has switched the motors of its robot off."""

    ON = 'on'
    OFF = 'off'
    UNKNOWN = 'unknown'


_LEVELS = {
    State.IDLE: DiagnosticStatus.OK,
    State.PAUSED: DiagnosticStatus.OK,
    State.FOLLOWING: DiagnosticStatus.OK,
    State.EMERGENCY: DiagnosticStatus.ERROR,
}


@dataclass(frozen=True)
class GuardReport:
    """What a guard says of itself.

    Attributes:
        state: What it lets its robot do.
        reason: Why the robot stands, for people; empty if it need not.
        private: Whether the robot's base listens to the guard alone.
        power: Whether its motors are on, as far as the guard has switched them.
        source: GID of the publisher whose commands it follows, in hexadecimal; empty if none.
    """

    state: State
    reason: str
    private: bool
    power: Power
    source: str

    @property
    def stops(self) -> bool:
        """Whether it holds a robot that its bridge wants to move, until somebody starts it."""
        return self.state not in (State.IDLE, State.PAUSED, State.FOLLOWING)

    def message(self, name: str, topic: str) -> DiagnosticStatus:
        """Return the message; `topic` is where the robot's base listens."""
        values = {
            'state': self.state.value,
            'private': 'yes' if self.private else 'no',
            'motor_power': self.power.value,
            'source': self.source,
        }
        return DiagnosticStatus(
            level=_LEVELS.get(self.state, DiagnosticStatus.WARN),
            name=name,
            message=self.reason,
            hardware_id=topic,
            values=[KeyValue(key=key, value=value) for key, value in values.items()],
        )

    @classmethod
    def of(cls, message: DiagnosticStatus) -> GuardReport:
        """Return what a message says; what is not understood counts as a robot that is held."""
        values = {item.key: item.value for item in message.values}
        try:
            state, power = State(values.get('state')), Power(values.get('motor_power'))
        except ValueError:
            state, power = State.HELD, Power.UNKNOWN
        reason = message.message
        if state is State.HELD and not reason:
            reason = 'its report is not understood'
        private = values.get('private') == 'yes'
        return cls(state, reason, private, power, values.get('source', ''))


SILENT_AFTER_S = 0.5
"""Silence in s from which a guard counts as gone; it reports five times a second."""

MISSING = 'no cmd_vel_guard on it'
_SILENT = 'its cmd_vel_guard is silent'


class GuardWatch:
    """Knows what the guard of a robot says.

    Attributes:
        report: What it said last; None before the first word.
        intruder: Who else publishes what only the guard may; empty if nobody.
        doubt: Why what is said as its guard is not believed; empty if it is.
    """

    def __init__(self, node: Node, namespace: str) -> None:
        """Listen through a node to the guard in a robot's namespace (without a slash)."""
        self.report: GuardReport | None = None
        self._node = node
        self._topic = f'/{namespace}/{topics.GUARD_STATE}'
        self._heard_by = f'/{namespace}/{topics.CMD_VEL}'
        self._guarded = f'/{namespace}/{topics.CMD_VEL_GUARDED}'
        self.intruder = self.doubt = ''
        self._heard = self._now = -math.inf
        self._nb_senders = 0
        self._messages = PolledTopic(
            node, DiagnosticStatus, self._topic, self._on_report, qos.STATE
        )

    def take(self, now: float) -> None:
        """Take what has come; `now` is in s on a steady clock."""
        self._now = now
        self._messages.take()

    def look_around(self) -> set[bytes]:
        """See who speaks as the guard; returns the processes that may command zero as such."""
        node = self._node
        found = cmd_vel_topics.publishers(node, self._topic)
        self._nb_senders = len(found)
        hear = {one.participant for one in cmd_vel_topics.listeners(node, self._heard_by)}
        guards = cmd_vel_topics.participants(node, self._guarded) & hear
        speakers = {one.participant for one in found}
        self.doubt = ''
        if len(found) > 1:
            self.doubt = f'{len(found)} nodes speak as its guard'
        elif speakers - guards:
            self.doubt = f'{found[0].full_name} speaks as its guard, and is none'
        known = speakers if speakers and not self.doubt else guards
        past = cmd_vel_topics.strangers(node, self._guarded, known)
        self.intruder = f'{past[0]} commands it past its guard' if past else ''
        return speakers if self.is_open and not self.doubt else set()

    @property
    def is_open(self) -> bool:
        """Whether the base of the robot hears cmd_vel itself, past its guard."""
        return self.report is not None and not self.report.private and not self.doubt

    def is_there(self) -> bool:
        """Return whether it has been heard of late."""
        return self._now - self._heard <= SILENT_AFTER_S

    @property
    def is_known(self) -> bool:
        """Whether there is one, or was, even if it says nothing."""
        return bool(self.report or self._nb_senders)

    @property
    def heard_report(self) -> GuardReport | None:
        """What it said of late; None if it said nothing."""
        return self.report if self.is_there() else None

    @property
    def has_ended(self) -> bool:
        """Whether it has fallen silent, and its robot hears nobody else."""
        return self.report is not None and self.report.private and not self.is_there()

    def trouble(self, demanded: bool) -> str:
        """Return why its robot must stand; empty if it need not.

        Args:
            demanded: Whether there must be a guard.
        """
        if self.doubt:
            return self.doubt
        if not self.is_there():
            return (_SILENT if self.is_known else MISSING) if demanded else ''
        assert self.report
        return f'its guard stops it: {self.report.reason}' if self.report.stops else ''

    def _on_report(self, message: DiagnosticStatus) -> None:
        if not self.doubt:
            self.report, self._heard = GuardReport.of(message), self._now
