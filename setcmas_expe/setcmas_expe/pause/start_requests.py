"""Requests to start robots, without the late and the repeated ones."""

from __future__ import annotations

import math

REPEATS_WITHIN_S = 2.5
"""`ros2 topic pub` without --once repeats once a second; a person does not so for long."""

REACTION_S = 1.0
"""Who presses within this time of a pause that came by itself meant to pause, not to start. Nor
does a key or a button that is held down, and repeats itself, or that bounces."""


class StartRequests:
    """Judges wishes to start; all times in s on a steady clock."""

    def __init__(self, now: float) -> None:
        """Begin at a time: whoever says go by then is no witness of this experiment."""
        self._go_heard = now
        self._stopped_itself = self._pressed = -math.inf

    def note_pause(self, by_itself: bool, now: float) -> None:
        """Note that the robots were paused: by themselves, or by a person."""
        self._stopped_itself = now if by_itself else -math.inf

    def repeated(self, paused: bool, now: float) -> bool:
        """Take a message on /pause; returns whether it is a go that somebody keeps sending.

        A publisher that was left running would start the robots as soon as they are ready, and
        after each pause again.
        """
        if paused:
            return False
        before, self._go_heard = self._go_heard, now
        return now - before < REPEATS_WITHIN_S

    def hasty(self, now: float) -> bool:
        """Take a press of the key or button that toggles; returns whether it must not start.

        It crossed a pause that came by itself, or came at once after another press.
        """
        before, self._pressed = self._pressed, now
        return now - max(before, self._stopped_itself) < REACTION_S
