"""Obedience of a robot: whether it does what it is commanded, and stops when commanded zero."""

from __future__ import annotations

from setcmas_simu.robots.model import VelocityLimits

DISOBEYS_AFTER_S = 0.7
"""Time in s that a robot may take to follow."""

_COMMANDED_M_S = 0.05
_STANDS_M_S = 0.01
_TURNS_M_S = 0.03
_SILENT_AFTER_S = 1.0
_OLD_S = 0.3  # what is older tells nothing of wheels that turn


class Obedience:
    """Compares commands with the speed of the wheels; all times in s on a steady clock."""

    def __init__(self, limits: VelocityLimits) -> None:
        """Begin without having heard of the wheels of a robot."""
        self._limits = limits
        self._wheels = 0.0
        self._heard: float | None = None
        self._follows = self._stops = 0.0  # when it last did as it was commanded

    def hear(self, V: float, omega: float, now: float) -> None:
        """Take the forward speed (m/s) and the turn rate (rad/s) that the wheels had."""
        if self._heard is None:
            self._follows = self._stops = now
        self._wheels, self._heard = self._limits.faster_wheel(V, omega), now

    def update(self, V: float, omega: float, now: float) -> str:
        """Take what was commanded last; returns what is wrong with the robot, empty if nothing.

        Args:
            V: Forward speed in m/s.
            omega: Turn rate in rad/s.
            now: The time.
        """
        if self._heard is None:
            return ''
        if now - self._heard > _SILENT_AFTER_S:
            self._follows = self._stops = now
            return 'its wheel odometry is silent; is it switched off?'
        if self._wheels > _STANDS_M_S or self._limits.faster_wheel(V, omega) <= _COMMANDED_M_S:
            self._follows = now
        if V or omega or self._wheels <= _TURNS_M_S or now - self._heard > _OLD_S:
            self._stops = now
        if now - self._follows > DISOBEYS_AFTER_S:
            return 'its wheels stand, although it is commanded to move: are its motors on?'
        if now - self._stops > DISOBEYS_AFTER_S:
            return 'its wheels turn, although it is commanded zero'
        return ''


RUNS_AWAY_AFTER_S = 1.0
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
        if abs(speed) <= MOVES_M_S or now - since < RUNS_AWAY_AFTER_S:
            self.robots.pop(robot, None)
            return False
        is_new = robot not in self.robots
        self.robots[robot] = abs(speed)
        return is_new
