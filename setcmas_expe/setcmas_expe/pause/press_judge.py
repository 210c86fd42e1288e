"""Judges presses of keys and buttons: which start robots, and which release a stop."""

from __future__ import annotations

import math

REACTION_S = 1.0
"""A press within this time (s) of an automatic pause is not meant as a start; nor is one within
this time of another press, because the key may be held or bounce."""

REPEATS_WITHIN_S = 0.8
"""Longest time after which a held key repeats itself for the first time, in s."""

RELEASED_AFTER_S = 0.3
"""Silence after which a held key or button counts as released, in s."""

RELEASES_WITHIN_S = 3.0
"""Longest time between the two presses that release a stop, in s."""

_LETS_GO_WITHIN_S = 2.0  # until guards and bridge have received a release


class StartRequests:
    """Judges single presses; all times in s on a steady clock."""

    def __init__(self) -> None:
        self._stopped_itself = self._pressed = -math.inf

    def note_pause(self, by_itself: bool, now: float) -> None:
        """Note that the robots paused, automatically or by a person."""
        self._stopped_itself = now if by_itself else -math.inf

    def hasty(self, now: float) -> bool:
        """Note a press; return whether it comes too soon to start robots."""
        before, self._pressed = self._pressed, now
        return now - max(before, self._stopped_itself) < REACTION_S


class HeldStart:
    """Judges the presses of a key or button that must be held; all times in s."""

    def __init__(self) -> None:
        self._pressed = -math.inf
        self._spent = False

    def pressed(self, now: float) -> bool:
        """Note a press; return whether it repeats, so that the key is held."""
        repeated = now - self._pressed < REPEATS_WITHIN_S
        self._spent = self._spent and repeated
        self._pressed = now
        return repeated and not self._spent

    def note_pause(self, now: float) -> None:
        """Note that the robots paused: a held key must be released first."""
        self._spent = not self.released(now)

    def released(self, now: float) -> bool:
        """Return whether nothing is held."""
        return now - self._pressed > RELEASED_AFTER_S


class Emergency:
    """The stop of the pause node; all times in s on a steady clock.

    Attributes:
        why: Its reason; empty if there is none.
    """

    def __init__(self) -> None:
        self.why = ''
        self._asked = self._pressed = self._released = -math.inf

    def stop(self, why: str) -> bool:
        """Stop; return whether that is new."""
        new = not self.why
        self.why = self.why or why
        self._asked = -math.inf
        return new

    def take_over(self, why: str, now: float) -> bool:
        """Take over the stop of a guard or the bridge; return whether it is a new stop."""
        late = now - self._released < _LETS_GO_WITHIN_S
        return not (self.why or late) and self.stop(why)

    @property
    def is_half_released(self) -> bool:
        """Whether the first of the two presses has been made."""
        return self._asked > -math.inf

    def release(self, now: float) -> bool:
        """Note a press of the releasing key; return whether it was the second and released.

        A held key repeats itself: such a repetition cancels the first press.
        """
        repeated = now - self._pressed < REPEATS_WITHIN_S
        again = not repeated and now - self._asked < RELEASES_WITHIN_S
        self._asked, self._pressed = -math.inf if repeated else now, now
        if again:
            self.why, self._asked, self._released = '', -math.inf, now
        return again
