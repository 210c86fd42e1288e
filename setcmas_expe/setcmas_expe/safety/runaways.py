"""Robots that move although they are commanded zero."""

from __future__ import annotations

AFTER_S = 1.0
"""Time in s that a robot takes at most to come to rest, with motion capture's delay."""

MOVES_M_S = 0.03
"""Speed in m/s above which a robot moves: motion capture of one that stands shows less."""


class Runaways:
    """Notices robots that do not stop: somebody else commands them, or they hear nothing.

    Whoever reports leaves out robots whose wheels stand: these are carried. Where no wheels are
    heard of, one that came to rest, and that nobody else commands, moves because it is carried.

    Attributes:
        robots: Speed in m/s of each robot that does not stop.
    """

    def __init__(self) -> None:
        """Begin with robots that stand."""
        self.robots: dict[int, float] = {}
        self._stops_since: dict[int, float] = {}  # while a robot has not come to rest

    def update(self, robot: int, is_zero: bool, speed: float, is_driven: bool, now: float) -> bool:
        """Take what a robot is commanded and how fast it is; returns whether it is a new runaway.

        Args:
            robot: Number of the robot.
            is_zero: Whether it is commanded zero.
            speed: Measured speed of its faster wheel in m/s: it may spin on the spot.
            is_driven: Whether it cannot be carried: its wheels turn, or somebody else commands it.
            now: Time in s on a steady clock.
        """
        if not is_zero:
            self._stops_since[robot] = now
        elif abs(speed) <= MOVES_M_S:
            self._stops_since.pop(robot, None)
        if is_driven and abs(speed) <= MOVES_M_S:
            self._stops_since[robot] = now
        elif is_driven:
            self._stops_since.setdefault(robot, now)
        since = self._stops_since.get(robot, now)
        if abs(speed) <= MOVES_M_S or now - since < AFTER_S:
            self.robots.pop(robot, None)
            return False
        is_new = robot not in self.robots
        self.robots[robot] = abs(speed)
        return is_new
