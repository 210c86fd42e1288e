"""Wishes to start robots: by a press of their own, or by a key or button that is held."""

from __future__ import annotations

import math

REACTION_S = 1.0
"""Who presses within this time of a pause that came by itself meant something else than a start.
Nor does a key or a button start robots that is held down, and repeats itself, or that bounces."""

REPEATS_WITHIN_S = 0.8
"""A key that is held down repeats itself after this time at the latest, first of all."""

RELEASED_AFTER_S = 0.3
"""Silence of a key or a button that was held from which it counts as released."""


class StartRequests:
    """Judges single presses; all times in s on a steady clock."""

    def __init__(self) -> None:
        """Begin without any."""
        self._stopped_itself = self._pressed = -math.inf

    def note_pause(self, by_itself: bool, now: float) -> None:
        """Note that the robots were paused: by themselves, or by a person."""
        self._stopped_itself = now if by_itself else -math.inf

    def hasty(self, now: float) -> bool:
        """Take a press; returns whether it must not start robots.

        It crossed a pause that came by itself, or came at once after another press.
        """
        before, self._pressed = self._pressed, now
        return now - max(before, self._stopped_itself) < REACTION_S


class HeldStart:
    """Judges the presses of a key or a button that has to be held; all times in s."""

    def __init__(self) -> None:
        """Begin with nothing held."""
        self._pressed = -math.inf
        self._spent = False

    def pressed(self, now: float) -> bool:
        """Take a press; returns whether it is held, for this is not the first of them."""
        repeated = now - self._pressed < REPEATS_WITHIN_S
        self._spent = self._spent and repeated
        self._pressed = now
        return repeated and not self._spent

    def note_pause(self, now: float) -> None:
        """Note that the robots were paused: whoever holds on has to let go first."""
        self._spent = not self.released(now)

    def released(self, now: float) -> bool:
        """Return whether nothing is held any more."""
        return now - self._pressed > RELEASED_AFTER_S
