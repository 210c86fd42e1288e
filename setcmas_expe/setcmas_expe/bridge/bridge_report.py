"""Report of the cmd_vel bridge of a robot (bridge_state), for the pause node and the terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec

from setcmas_ctrl.pause_reason import PauseCause, PauseReason
from setcmas_expe.bridge.bridge_decision import BridgeState, Cause, Decision


class BridgeReport(msgspec.Struct, frozen=True, kw_only=True):
    """What a bridge has decided about its robot.

    In ROS it is a DiagnosticStatus: its name, level and message, the others as key-value pairs.

    Attributes:
        name: Name of the robot.
        level: That of DiagnosticStatus: 0 well, 1 stopped, 2 lost.
        reason: Why it may not move as wanted, in words; empty if it may.
        state: What it may do.
        ready: Whether it moves, or only waits for the operator.
        cause: Name of the `Cause` of its stop; empty if it may move, or if only a pause keeps it.
        why: The cause in words.
        pause: Name of the `PauseCause` for which all robots are paused; empty if they are not.
        pause_why: The cause of the pause in words.
        runs_away: Whether it moves although it is commanded zero.
        pose_age: Age of its last good pose in s; None if unknown, as are the next two.
        battery: Its charge in percent.
        speed: Its forward speed in m/s.
    """

    name: str
    level: int
    reason: str
    state: BridgeState = BridgeState.STOPPED
    ready: bool = False
    cause: str = ''
    why: str = ''
    pause: str = ''
    pause_why: str = ''
    runs_away: bool = False
    pose_age: float | None = None
    battery: float | None = None
    speed: float | None = None

    @classmethod
    def of(cls, decision: Decision, **more: Any) -> BridgeReport:
        """Return the report of a decision, with the fields that the decision does not have."""
        why, pause = decision.why, decision.pause
        return cls(
            reason=decision.text,
            state=decision.state,
            ready=decision.is_ready,
            cause=why.cause.name if why else '',
            why=why.text if why else '',
            pause=pause.cause.name if pause else '',
            pause_why=pause.text if pause else '',
            **more,
        )

    @classmethod
    def read(cls, name: str, level: int, reason: str, values: Mapping[str, str]) -> BridgeReport:
        """Return the report with such key-value pairs; an invalid one is of a stopped robot."""
        known: dict[str, Any] = {key: value for key, value in values.items() if value}
        known |= {'name': name, 'level': level, 'reason': reason}
        try:
            return msgspec.convert(known, cls, strict=False)
        except msgspec.ValidationError:
            return cls(name=name, level=level, reason=reason)

    @property
    def values(self) -> dict[str, str]:
        """Its key-value pairs; unknown values are empty."""
        fields = msgspec.to_builtins(self)
        for key in ('name', 'level', 'reason'):
            del fields[key]
        return {key: '' if value is None else str(value) for key, value in fields.items()}

    @property
    def is_intruded(self) -> bool:
        """Whether another process commands the robot past its guard."""
        return self.cause == Cause.PAST_GUARD.name

    @property
    def held(self) -> PauseReason | None:
        """Why the bridges themselves pause all robots; None if they do not."""
        cause = PauseCause.__members__.get(self.pause)
        reason = PauseReason(cause, self.pause_why) if cause else None
        return None if reason and reason.is_of_operator else reason
