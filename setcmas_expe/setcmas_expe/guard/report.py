"""Report of a guard about its robot, and the message that carries it (guard_state)."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue


class State(enum.Enum):
    """What a guard lets its robot do."""

    IDLE = 'idle'
    """Nobody commands the robot."""
    PAUSED = 'paused'
    FOLLOWING = 'following'
    SILENT = 'silent'
    """Its commands have ended, or come late; it stands until it is started again."""
    RIVAL = 'rival'
    """Somebody else may command it; it stands until it is started again."""
    HELD = 'held'
    """It missed the pause that must come before a start."""
    EMERGENCY = 'emergency'


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
