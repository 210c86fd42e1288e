"""Playing of a run: where it stands, how fast it goes, and what was wished for it."""

from __future__ import annotations

import math

from setcmas_tools.bags.playback import PlayClock

SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0)
STEP_S = 0.1
_ROUNDING = 1e-6


class Play:
    """The time of a run that is shown, paused at first.

    Attributes:
        speed: How many times as fast as it was.
    """

    def __init__(self, t0: float, t1: float, at: float, now: float) -> None:
        """Stand at a time of a run that goes from t0 to t1, in s; `now` is a steady clock's."""
        self._t0, self._t1 = t0, t1
        self.speed = 1.0
        self._clock = PlayClock(self.speed, self._inside(at), now)
        self._clock.paused = True

    @property
    def paused(self) -> bool:
        """Whether it stands."""
        return self._clock.paused

    def at(self, now: float) -> float:
        """Return the time of the run; at its end it stands."""
        t = self._clock.at(now)
        if t >= self._t1 and not self._clock.paused:
            self._clock.move_to(self._t1, now)
            self._clock.paused = True
        return min(t, self._t1)

    def toggle(self, now: float) -> None:
        """Play or pause; from the end play again."""
        if self.paused and self.at(now) >= self._t1:
            self._clock.move_to(self._t0, now)
        self._clock.toggle(now)

    def seek(self, t: float, now: float) -> None:
        """Go on, or stand, from another time on."""
        self._clock.move_to(self._inside(t), now)

    def step(self, number: int, now: float) -> None:
        """Stand some steps of `STEP_S` further on, or back."""
        steps = self.at(now) / STEP_S
        whole = math.floor(steps + _ROUNDING) if number > 0 else math.ceil(steps - _ROUNDING)
        t = round((whole + number) * STEP_S, 6)
        self._clock.paused = True
        self.seek(t, now)

    def faster(self, number: int, now: float) -> None:
        """Take a speed that is some places further on in `SPEEDS`, or back."""
        place = SPEEDS.index(self.speed) + number
        self.speed = SPEEDS[min(max(place, 0), len(SPEEDS) - 1)]
        self._clock.turn(self.speed, now)

    def _inside(self, t: float) -> float:
        return min(max(t, self._t0), self._t1)
