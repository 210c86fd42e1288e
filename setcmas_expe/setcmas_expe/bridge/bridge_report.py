"""Report of the cmd_vel bridge of a robot (bridge_state), which the pause node reads."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from setcmas_ctrl.pause_reason import PauseCause, PauseReason
from setcmas_expe.bridge.decision import Cause, Decision, State

_YES = 'yes'


def report_values(decision: Decision) -> dict[str, str]:
    """Return a decision as the key-value pairs of a DiagnosticStatus."""
    pause = decision.pause
    return {
        'state': decision.state.value,
        'cause': decision.why.cause.name if decision.why else '',
        'ready': _YES if decision.is_ready else '',
        'pause': pause.cause.name if pause else '',
        'pause_text': pause.text if pause else '',
        'pause_may_be_load': _YES if pause and pause.may_be_load else '',
    }


@dataclass(frozen=True)
class BridgeReport:
    """What a bridge has decided about its robot.

    Attributes:
        state: What the robot may do.
        cause: Why it may not move as wanted; None if it may, or if only a pause keeps it.
        is_ready: Whether it moves, or only waits for the operator.
        pause: Why all robots are paused; None if they are not.
    """

    state: State
    cause: Cause | None
    is_ready: bool
    pause: PauseReason | None

    @classmethod
    def of(cls, values: Mapping[str, str]) -> BridgeReport:
        """Return the report in key-value pairs; what is unknown counts as stopped, not ready."""
        state = next((one for one in State if one.value == values.get('state')), State.STOPPED)
        held = PauseCause.__members__.get(values.get('pause', ''))
        by_load = values.get('pause_may_be_load') == _YES
        return cls(
            state,
            Cause.__members__.get(values.get('cause', '')),
            values.get('ready') == _YES,
            PauseReason(held, values.get('pause_text', ''), by_load) if held else None,
        )
