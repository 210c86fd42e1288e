"""Decisions of a guard: whose commands it follows, whether it lets them through, and why not."""

from __future__ import annotations

import enum
from collections.abc import Set as AbstractSet
from dataclasses import dataclass

from setcmas_ctrl.driving.fleet_pause import BY_WISH


class Source:
    """Pins who commands a robot, by the identifier that DDS gives to a process.

    Who sent a message cannot be told (rclpy does not say), so nobody is followed while there are
    several. The operator's pause node stands by to command zero: it does not count.

    Attributes:
        pinned: The process that is followed; empty if there is none.
    """

    def __init__(self) -> None:
        """Begin without any."""
        self.pinned = b''

    def conflict(self, found: AbstractSet[bytes], operator: bytes | None, free: bool) -> str:
        """Return why nobody is to be followed; empty if there is one, or none.

        Args:
            found: The processes that publish commands.
            operator: That of the pause node; None if it is not known.
            free: Whether the robot may move now: then nobody may take the place of another.
        """
        rest = found - {operator} if len(found) > 1 else found
        if len(rest) > 1:
            return 'several nodes command it'
        now = next(iter(rest), b'')
        if now and now != self.pinned and self.pinned and free:
            return 'another node commands it than at the start'
        if now or not free:
            self.pinned = now
        return ''


UNHEARD = 'its base does not listen; is its bringup running?'


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


@dataclass(frozen=True)
class Situation:
    """What a guard knows at a moment.

    Attributes:
        emergency: Whether an emergency stop is held.
        intruder: Who else publishes what only the guard may; empty if nobody.
        conflict: Why nobody's commands are to be followed; empty if somebody's are.
        is_heard: Whether the base listens.
        is_commanded: Whether there is somebody who commands the robot.
        has_ended: Whether there is no command to follow.
        ending: Why there is none.
    """

    emergency: bool
    intruder: str
    conflict: str
    is_heard: bool
    is_commanded: bool
    has_ended: bool
    ending: str


class Standing:
    """Why a robot stands; whatever stopped it, it waits for a pause and then a start.

    Attributes:
        is_free: Whether commands are let through.
    """

    def __init__(self, resumes: bool) -> None:
        """Begin with a robot that stands.

        Args:
            resumes: Whether it goes on by itself when commands come again after a silence.
        """
        self._resumes = resumes
        self._was = State.HELD
        self._is_let_go = self.is_free = False

    def hold(self, situation: Situation) -> str:
        """Return why the robot must wait for a start; empty if it need not."""
        state, why = _trouble(situation)
        if state is State.SILENT and (self._resumes or not self._is_let_go):
            return ''
        if state is not None:  # an emergency stop is over once it is released
            self._was = State.HELD if state is State.EMERGENCY else state
        return why

    def decide(self, situation: Situation, paused: str) -> tuple[State, str]:
        """Return what the robot is let do, and why it stands, by the pause state then."""
        state, reason = self._decided(situation, paused)
        self._is_let_go, self.is_free = not paused, state is State.FOLLOWING
        return state, reason

    def _decided(self, situation: Situation, paused: str) -> tuple[State, str]:
        state, why = _trouble(situation)
        if state is not None and state is not State.SILENT:
            return state, why
        if not situation.is_commanded:
            return State.IDLE, ''
        if paused == BY_WISH:
            self._was = State.HELD
            return State.PAUSED, ''
        if paused:
            return self._was, paused.removeprefix(f'{BY_WISH}: ')
        return (state, why) if state else (State.FOLLOWING, '')


def _trouble(situation: Situation) -> tuple[State | None, str]:
    if situation.emergency:
        return State.EMERGENCY, 'emergency stop'
    if situation.intruder or situation.conflict:
        return State.RIVAL, situation.intruder or situation.conflict
    if not situation.is_heard:
        return State.HELD, UNHEARD
    return (State.SILENT, situation.ending) if situation.has_ended else (None, '')
