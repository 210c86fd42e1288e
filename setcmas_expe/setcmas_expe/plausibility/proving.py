"""Proof of who is who: unproved robots crawl in turns until motion capture has shown them."""

from __future__ import annotations

import math
from collections.abc import Iterable

CRAWL_M_S = 0.05
"""Forward speed of a robot that is not proved yet, in m/s."""

CRAWL_RAD_S = 1.0
"""Its turn rate, in rad/s."""

PROOF_M = 0.10
"""Distance in m that it must be seen to go as it is told, without any deviation."""

_SHORTEST_TURN_S = 0.7  # a robot that moves out of its turn is noticed within that
_SPARE = 1.1  # it gathers speed, and is seen late


class Proving:
    """Lets unproved robots crawl, no two of them at all the same times.

    Two unicycles that go ahead show alike, whichever is which. So time is cut into turns, two for
    each binary digit of a robot's number: it may move in one of them and stands in the other. Any
    two robots differ in a digit, hence one must stand while the other moves.

    Attributes:
        left: Distance in m that each unproved robot must still go, by number.
    """

    def __init__(self, robots: Iterable[int], proved: Iterable[int] = ()) -> None:
        """Begin with all robots of a lab, and those among them that are proved."""
        robots = list(robots)
        self._digits = (len(robots) - 1).bit_length()
        self._turn_s = max(_SHORTEST_TURN_S, _SPARE * PROOF_M / CRAWL_M_S / max(1, self._digits))
        self._time = 0.0
        self._doubted: dict[int, bool] = {}  # whether it wants to go
        self.left = {robot: PROOF_M for robot in robots if robot not in set(proved)}

    def go_on(self, seconds: float) -> None:
        """Let the time of turns go on, while robots are not paused."""
        self._time += seconds

    def doubt(self, robot: int) -> None:
        """Let a robot prove itself again, before others move: standing shows nothing."""
        self.left[robot] = PROOF_M
        self._doubted[robot] = True

    @property
    def others_wait(self) -> bool:
        """Whether robots stand because one that is doubted wants to prove itself."""
        return any(self._doubted.values())

    def allowed(self, robot: int, V: float, omega: float) -> tuple[float, float]:
        """Return the speeds (m/s, rad/s) that a robot may have of those that it wants."""
        if robot in self._doubted:
            self._doubted[robot] = V != 0.0
        elif self.others_wait:
            return 0.0, 0.0
        if robot not in self.left or not (math.isfinite(V) and math.isfinite(omega)):
            return V, omega
        if not self._has_turn(robot):
            return 0.0, 0.0
        excess = max(1.0, abs(V) / CRAWL_M_S, abs(omega) / CRAWL_RAD_S)
        return V / excess, omega / excess

    def went(self, robot: int, metres: float) -> bool:
        """Note that a robot was seen to go some way as it was told, or back where below 0.

        Returns:
            Whether that proves it now.
        """
        if robot not in self.left:
            return False
        self.left[robot] -= metres
        if self.left[robot] > 0.0:
            return False
        del self.left[robot]
        self._doubted.pop(robot, None)
        return True

    def _has_turn(self, robot: int) -> bool:
        if not self._digits:
            return True
        digit, half = divmod(int(self._time / self._turn_s) % (2 * self._digits), 2)
        return (robot - 1) >> digit & 1 != half
