"""Start key, pressed alone: a word that is typed or pasted starts no robots."""

from __future__ import annotations

import math

ALONE_S = 0.3
"""Time in s before and after the key in which no other may be pressed."""


class StartKey:
    """Judges the keys of a terminal; all times in s on a steady clock."""

    def __init__(self, held: bool) -> None:
        """Begin with nothing pressed.

        Args:
            held: Whether the key counts only while it is held down. It is told at once then: a
                second press is needed anyway, and its release must not be late.
        """
        self._held = held
        self._other, self._waiting_since = -math.inf, math.inf

    def pressed(self, keys: str, now: float) -> bool:
        """Take the keys since the last call, as they came; returns whether they start robots."""
        if keys and not (set(keys) <= {'s', 'S'} and (self._held or len(keys) == 1)):
            self._other, self._waiting_since = now, math.inf
        elif keys and now - self._other > ALONE_S:
            self._waiting_since = min(self._waiting_since, now)
        starts = now - self._waiting_since >= (0.0 if self._held else ALONE_S)
        if starts:
            self._waiting_since = math.inf
        return starts
