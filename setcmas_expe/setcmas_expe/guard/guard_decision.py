"""Decisions on a robot, by its guard: what it may do, and why."""

from __future__ import annotations

import enum
import math
from collections.abc import Sequence
from dataclasses import dataclass

from setcmas_ctrl.pause_reason import PauseReason


class GuardState(enum.Enum):
    """What a guard lets its robot do."""

    IDLE = 'idle'
    PAUSED = 'paused'
    FOLLOWING = 'following'
    SILENT = 'silent'
    CONTESTED = 'contested'
    INTRUDED = 'intruded'
    DEAF = 'deaf'
    OBSTRUCTED = 'obstructed'
    BLIND = 'blind'
    OPEN = 'open'
    UNCONNECTED = 'unconnected'
    HELD = 'held'
    EMERGENCY = 'stop'

    @property
    def stops(self) -> bool:
        """Whether the robot stays stopped until a pause and a start."""
        return self not in (GuardState.IDLE, GuardState.PAUSED, GuardState.FOLLOWING)


_TEXTS = {
    GuardState.SILENT: 'its commands have ended, or come late',
    GuardState.CONTESTED: '{} command it',
    GuardState.INTRUDED: '{} commands it past its guard',
    GuardState.DEAF: 'it does not obey zero commands: its motors are off',
    GuardState.OBSTRUCTED: 'its lidar sees something {} m ahead',
    GuardState.BLIND: 'its lidar is silent or covered',
    GuardState.OPEN: (
        'its base listens to cmd_vel directly: remap it to cmd_vel_guarded (docs/lab_setup.md)'
    ),
    GuardState.UNCONNECTED: (
        'its base does not listen; is its bringup running? If another process sends odom, nothing '
        'else may listen to cmd_vel_guarded'
    ),
    GuardState.EMERGENCY: 'a stop is held; R twice releases it',
}


@dataclass(frozen=True)
class GuardDecision:
    """What a robot may do.

    Attributes:
        state: What it may do.
        reason: Why it is stopped, for people; empty if it is not.
        lidar: Whether its guard stops it when something is in its way.
    """

    state: GuardState
    reason: str = ''
    lidar: bool = False


def stopped(state: GuardState, detail: str = '') -> GuardDecision:
    """Return the decision to stop a robot, with what is to be named in its reason."""
    return GuardDecision(state, _TEXTS[state].format(detail))


@dataclass(frozen=True)
class GuardSituation:
    """What a guard knows at a moment.

    Attributes:
        emergency: Whether a person, or a node, has stopped all robots for good.
        commanders: Names of the nodes that command the robot, without the pause node's.
        intruders: Names of those that publish to its base past the guard.
        disobeys: Whether its wheels turn despite zero commands.
        base: How its base does not listen to the guard alone; None if it does.
        has_ended: Whether there is no command to follow.
        clearance: Distance in m to what stands in the way within the braking distance; inf if
            nothing does, NaN if the lidar is silent or covered.
    """

    emergency: bool
    commanders: Sequence[str]
    intruders: Sequence[str]
    disobeys: bool
    base: GuardState | None
    has_ended: bool
    clearance: float = math.inf


_NOT_STARTED = GuardDecision(GuardState.HELD, 'it waits for a pause and a start')


class StartLatch:
    """Keeps a robot stopped, whatever stopped it, until a pause and then a start."""

    def __init__(self) -> None:
        """Start with a stopped robot."""
        self._stop: GuardDecision | None = _NOT_STARTED

    def decide(self, situation: GuardSituation, pause: PauseReason | None) -> GuardDecision:
        """Return what the robot may do, given why robots are paused; None if they are not."""
        if trouble := _trouble(situation):
            is_over_later = trouble.state is GuardState.EMERGENCY or situation.base
            self._stop = _NOT_STARTED if is_over_later else trouble
            return trouble
        if self._stop and not situation.commanders:
            return GuardDecision(GuardState.IDLE)
        if pause and pause.is_of_operator:
            self._stop = None
            return GuardDecision(GuardState.PAUSED)
        held = GuardDecision(GuardState.HELD, pause.text) if pause else _danger(situation)
        self._stop = self._stop or held
        return self._stop or GuardDecision(GuardState.FOLLOWING)


def _trouble(situation: GuardSituation) -> GuardDecision | None:
    """Return what is wrong even with a robot that is paused."""
    if situation.intruders:  # a person must know, because a stop may not hold the robot
        return stopped(GuardState.INTRUDED, ' and '.join(situation.intruders))
    if situation.emergency:
        return stopped(GuardState.EMERGENCY)
    if situation.disobeys:
        return stopped(GuardState.DEAF)
    if len(situation.commanders) > 1:
        return stopped(GuardState.CONTESTED, ' and '.join(situation.commanders))
    return stopped(situation.base) if situation.base else None


def _danger(situation: GuardSituation) -> GuardDecision | None:
    """Return why a robot that is started may not move."""
    if situation.has_ended:
        return stopped(GuardState.SILENT)
    if math.isnan(situation.clearance):
        return stopped(GuardState.BLIND)
    if situation.clearance < math.inf:
        return stopped(GuardState.OBSTRUCTED, f'{situation.clearance:.2f}')
    return None
