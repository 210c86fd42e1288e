"""Decisions of a guard: which process it follows, whether its robot may move, and why not."""

from __future__ import annotations

import enum
from collections.abc import Set as AbstractSet
from dataclasses import dataclass

from setcmas_ctrl.experiment_pause import PauseReason

NO_LISTENER = 'its base does not listen; is its bringup running?'


class State(enum.Enum):
    """What a guard lets its robot do."""

    IDLE = 'idle'  # no process commands the robot
    PAUSED = 'paused'
    FOLLOWING = 'following'
    SILENT = 'silent'  # its commands ended or come late; it waits for a start
    RIVAL = 'rival'  # a second process may command it; it waits for a start
    HELD = 'held'  # it missed the pause that must come before a start
    EMERGENCY = 'emergency'


class Source:
    """Pins the process that commands a robot, by its DDS identifier.

    rclpy does not say who sent a message, so the guard follows none of several. The pause node is
    ready to command zero and does not count.

    Attributes:
        pinned: The process that the guard follows; empty if there is none.
    """

    def __init__(self) -> None:
        self.pinned = b''

    def conflict(self, found: AbstractSet[bytes], operator: bytes | None, free: bool) -> str:
        """Return why the guard must follow no process; empty if there is one, or none.

        Args:
            found: The processes that publish commands.
            operator: The process of the pause node; None if unknown.
            free: Whether the robot may move now: then no process may replace another.
        """
        rest = found - {operator} if len(found) > 1 else found
        if len(rest) > 1:
            return 'several nodes command it'
        now = next(iter(rest), b'')
        if now and now != self.pinned and self.pinned and free:
            return 'a different node than at the start commands it'
        if now or not free:
            self.pinned = now
        return ''


@dataclass(frozen=True)
class Situation:
    """What a guard knows at a moment.

    Attributes:
        emergency: Whether an emergency stop is held.
        intruder: Who else publishes to the base; empty if none.
        conflict: Why the guard must follow no process; empty if it may.
        base_listens: Whether the base listens.
        is_commanded: Whether a process commands the robot.
        has_ended: Whether there is no command to follow.
        ending: Why there is none.
    """

    emergency: bool
    intruder: str
    conflict: str
    base_listens: bool
    is_commanded: bool
    has_ended: bool
    ending: str


class StartLatch:
    """Keeps a robot stopped, whatever stopped it, until a pause and then a start.

    Attributes:
        is_free: Whether commands pass.
    """

    def __init__(self) -> None:
        """Start with a stopped robot."""
        self._was = State.HELD
        self._was_started = self.is_free = False

    def reason_to_wait(self, situation: Situation) -> str:
        """Return why the robot must wait for a start from now on; empty if it need not."""
        state, why = _trouble(situation)
        if state is State.SILENT and not self._was_started:
            return ''
        if state is not None:  # an emergency stop is over once it is released
            self._was = State.HELD if state is State.EMERGENCY else state
        return why

    def decide(self, situation: Situation, paused: PauseReason | None) -> tuple[State, str]:
        """Return the robot's new state and its reason, given the reason for a pause."""
        state, reason = self._decided(situation, paused)
        self._was_started, self.is_free = not paused, state is State.FOLLOWING
        return state, reason

    def _decided(self, situation: Situation, paused: PauseReason | None) -> tuple[State, str]:
        state, why = _trouble(situation)
        if state is not None and state is not State.SILENT:
            return state, why
        if not situation.is_commanded:
            return State.IDLE, ''
        if paused and paused.is_of_operator:
            self._was = State.HELD
            return State.PAUSED, ''
        if paused:
            return self._was, paused.text
        return (state, why) if state else (State.FOLLOWING, '')


def _trouble(situation: Situation) -> tuple[State | None, str]:
    if situation.emergency:
        return State.EMERGENCY, 'emergency stop'
    if situation.intruder or situation.conflict:
        return State.RIVAL, situation.intruder or situation.conflict
    if not situation.base_listens:
        return State.HELD, NO_LISTENER
    return (State.SILENT, situation.ending) if situation.has_ended else (None, '')
