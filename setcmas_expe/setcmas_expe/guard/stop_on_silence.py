"""Stop of a robot whose base hears its commands itself: zero once they have ended."""

from __future__ import annotations

import math

from setcmas_expe.guard.commands import SILENCE_S

REPEAT_S = 1.0
"""For how long the guard repeats zero, in s."""


class StopOnSilence:
    """Follows the commands of one robot; all times in s on a steady clock.

    The guard hears its own zeros like anybody's; since a zero never makes it act, they need not
    be told apart.
    """

    def __init__(self, now: float, silence_s: float = SILENCE_S) -> None:
        """Begin at a time: for all that is known, the robot moves, and nobody commands it."""
        self._silence_s = silence_s
        self._moving = True
        self._heard = now
        self._zero_until = -math.inf

    @property
    def moving(self) -> bool:
        """Whether the last command was to move, and nobody has stopped the robot since."""
        return self._moving

    def hear(self, V: float, omega: float, now: float) -> None:
        """Take a command; one that is not finite may move a robot, but never keeps it going."""
        if V == 0.0 and omega == 0.0:
            self._moving = False
        elif not self._moving or (math.isfinite(V) and math.isfinite(omega)):
            self._moving = True
            self._zero_until = -math.inf
            self._heard = now

    def must_stop(self, now: float) -> bool:
        """Return whether zero is to be published now."""
        if self._moving and now - self._heard >= self._silence_s:
            self._moving = False
            self._zero_until = now + REPEAT_S
        return now < self._zero_until
