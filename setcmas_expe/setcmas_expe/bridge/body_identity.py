"""Proof of which body is which robot: it crawls, and turns slowly, under motion capture."""

from __future__ import annotations

import math
from collections.abc import Iterable

CRAWL_M_S = 0.05
"""Forward speed of a robot that is not proved, in m/s."""

PROOF_M = 0.10
"""Distance in m that proves a robot, if it goes all of it as commanded."""

SLOW_TURN_RAD_S = 0.3
"""Turn rate of a robot until it has been seen to turn as commanded, in rad/s."""

PROOF_RAD = 0.3
"""Turn in rad that proves the axes of a body: under wrong ones a robot may drive straight."""

_CRAWL_RAD_S = 1.0  # once that turn is proved
_SHORTEST_TURN_S = 0.7  # time to notice a robot that moves out of its turn
_SPARE = 1.1  # for acceleration and delay


class Proving:
    """Lets unproved robots crawl in turns, so that their motions differ.

    Time is cut into turns, two for each binary digit of a robot's number: the robot may move in
    one of them. Any two robots differ in a digit, so that each moves while the other rests.

    Attributes:
        left: Distance in m that each unproved robot must still go, by number.
        left_to_turn: Angle in rad by which each robot must still turn, by number.
    """

    def __init__(self, robots: Iterable[int]) -> None:
        """Start with all robots of a lab; none is proved."""
        robots = list(robots)
        self._digits = (len(robots) - 1).bit_length()
        self._turn_s = max(_SHORTEST_TURN_S, _SPARE * PROOF_M / CRAWL_M_S / max(1, self._digits))
        self._time = 0.0
        self.left = dict.fromkeys(robots, PROOF_M)
        self.left_to_turn = dict.fromkeys(robots, PROOF_RAD)

    def go_on(self, seconds: float) -> None:
        """Advance the time of turns, while robots are not paused."""
        self._time += seconds

    def end(self, robot: int) -> None:
        """End the proof of a robot: another body may have its name."""
        self.left[robot], self.left_to_turn[robot] = PROOF_M, PROOF_RAD

    def allowed(self, robot: int, V: float, omega: float) -> tuple[float, float]:
        """Return the part of the wanted speeds (m/s, rad/s) that a robot may drive."""
        if not (math.isfinite(V) and math.isfinite(omega)):
            return V, omega
        if robot in self.left and not self._has_turn(robot):
            return 0.0, 0.0
        fastest, fastest_turn = math.inf, math.inf
        if robot in self.left:
            fastest, fastest_turn = CRAWL_M_S, _CRAWL_RAD_S
        if robot in self.left_to_turn:
            fastest_turn = SLOW_TURN_RAD_S
        excess = max(1.0, abs(V) / fastest, abs(omega) / fastest_turn)
        return V / excess, omega / excess

    def went(self, robot: int, metres: float, radians: float) -> bool:
        """Note how far a robot went and turned as commanded; return whether it is proved now.

        Distance and angle are negative against the command.
        """
        if robot in self.left_to_turn:
            left = self.left_to_turn[robot] - radians
            self.left_to_turn[robot] = min(left, PROOF_RAD)  # swinging leaves no debt
            if self.left_to_turn[robot] <= 0.0:
                del self.left_to_turn[robot]
        if robot not in self.left:
            return False
        self.left[robot] -= metres
        if self.left[robot] > 0.0:
            return False
        del self.left[robot]
        return True

    def _has_turn(self, robot: int) -> bool:
        if not self._digits:
            return True
        digit, half = divmod(int(self._time / self._turn_s) % (2 * self._digits), 2)
        return (robot - 1) >> digit & 1 != half
