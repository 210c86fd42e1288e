"""Emergency stop as its pause node holds it, and its release in two steps."""

from __future__ import annotations

import math

from setcmas_expe.pause.start_requests import REPEATS_WITHIN_S

RELEASES_WITHIN_S = 3.0
"""The second press comes within this time of the first, and later than a key repeats itself."""

_LETS_GO_WITHIN_S = 2.0  # guards and bridge have heard of a release by then


class Emergency:
    """The state that is held; all times in s on a steady clock.

    Attributes:
        why: How it came about; empty if there is none.
    """

    def __init__(self) -> None:
        """Begin without one."""
        self.why = ''
        self._asked = self._pressed = self._released = -math.inf

    def stop(self, why: str) -> bool:
        """Stop; returns whether that is new."""
        new = not self.why
        self.why = self.why or why
        self._asked = -math.inf
        return new

    def take_over(self, why: str, now: float) -> bool:
        """Make a stop one's own that a guard or the bridge holds; returns whether that is new."""
        late = now - self._released < _LETS_GO_WITHIN_S
        return not (self.why or late) and self.stop(why)

    def release(self, now: float) -> bool:
        """Take a press that is to release it; returns whether it was the second.

        A key that is held down repeats itself: what comes so soon spoils the press before it.
        """
        repeated = now - self._pressed < REPEATS_WITHIN_S
        again = not repeated and now - self._asked < RELEASES_WITHIN_S
        self._asked, self._pressed = -math.inf if repeated else now, now
        if again:
            self.why, self._asked, self._released = '', -math.inf, now
        return again
