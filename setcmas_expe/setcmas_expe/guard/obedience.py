"""Obedience of a robot: whether it moves as commanded, and stops when commanded zero."""

from __future__ import annotations

from setcmas_simu.robots.model import VelocityLimits

IGNORES_ZERO = 'its wheels turn despite zero commands'

FOLLOWS_WITHIN_S = 0.7
"""Longest time in s until the wheels begin to turn."""

SLOWS_WITHIN_S = 0.5
"""Longest time in s until the wheels slow down once zero is commanded."""

RUNS_AWAY_AFTER_S = 1.0
"""Longest time in s to come to rest, with motion capture's delay."""

MOVES_M_S = 0.03
"""Speed in m/s above which a robot moves; motion capture shows less for one at rest."""

_MEASUREMENTS = 6  # of wheels that go on: the robot's computer may be late
_SLOWER = 0.8  # share of the speed before
_COMMANDED_M_S = 0.05
_STANDS_M_S = 0.01
_SILENT_AFTER_S = 1.0
_OLD_S = 0.3  # largest age of wheels that turn


class Obedience:
    """Compares commands with the speed of the wheels; all times in s on a steady clock."""

    def __init__(self, limits: VelocityLimits) -> None:
        """Start without a measurement of the wheels."""
        self._limits = limits
        self._wheels = 0.0
        self._measured: float | None = None
        self._follows = self._stops = 0.0  # when it last did as commanded
        self._before = 0.0  # their fastest speed since then
        self._nb_measured = 0  # since then

    def measure(self, V: float, omega: float, now: float) -> None:
        """Note the forward speed (m/s) and the turn rate (rad/s) of the wheels."""
        if self._measured is None:
            self._follows = self._stops = now
        self._wheels, self._measured = self._limits.faster_wheel(V, omega), now
        self._nb_measured += 1

    def update(self, V: float, omega: float, now: float) -> str:
        """Note the last command (m/s, rad/s); return what is wrong, empty if nothing."""
        if self._measured is None:
            return ''
        if now - self._measured > _SILENT_AFTER_S:
            self._follows = self._stops = now
            return 'its wheel odometry is silent; is it switched off?'
        if self._wheels > _STANDS_M_S or self._limits.faster_wheel(V, omega) <= _COMMANDED_M_S:
            self._follows = now
        if V or omega or self._wheels <= MOVES_M_S or now - self._measured > _OLD_S:
            self._stops, self._before, self._nb_measured = now, 0.0, 0
        self._before = max(self._before, self._wheels)
        if now - self._follows > FOLLOWS_WITHIN_S:
            return 'its wheels do not turn as commanded: are its motors on?'
        has_slowed = self._wheels < _SLOWER * self._before
        patience = RUNS_AWAY_AFTER_S if has_slowed else SLOWS_WITHIN_S
        ignores = now - self._stops > patience and self._nb_measured >= _MEASUREMENTS
        return IGNORES_ZERO if ignores else ''


class Runaways:
    """Finds robots that do not stop: another process commands them, or no command reaches them.

    Robots whose wheels stand are carried, and left out. Without wheel odometry, a robot that came
    to rest and has no other commander is carried if it moves.

    Attributes:
        robots: Speed in m/s of each robot that does not stop.
    """

    def __init__(self) -> None:
        """Start with robots at rest."""
        self.robots: dict[int, float] = {}
        self._stops_since: dict[int, float] = {}  # until a robot has come to rest

    def update(self, robot: int, is_zero: bool, speed: float, is_driven: bool, now: float) -> bool:
        """Note a robot's command and speed; return whether it is a new runaway.

        Args:
            robot: Number of the robot.
            is_zero: Whether it is commanded zero.
            speed: Measured speed of its faster wheel in m/s: it may spin on the spot.
            is_driven: Whether it cannot be carried: its wheels turn, or it has another commander.
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
