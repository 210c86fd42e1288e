"""Obedience of a robot: whether it moves as commanded, and stops when commanded zero velocity."""

from __future__ import annotations

import enum
import math

from setcmas_simu.robots.model import VelocityLimits


class Disobedience(enum.Enum):
    """How the wheels of a robot disobey, with a text for people."""

    SILENT = 'its wheel odometry is silent; is it switched off?'
    DOES_NOT_TURN = 'its wheels do not turn as commanded: are its motors on?'
    IGNORES_ZERO = 'its wheels turn despite zero commands'


FOLLOWS_WITHIN_S = 0.7
"""Longest time in s until the wheels begin to turn."""

SLOWS_WITHIN_S = 0.5
"""Longest time in s until the wheels slow down once zero is commanded."""

SLOWS_WITHIN_OVER_RADIO_S = 0.7
"""The same where odometry comes over a radio link, up to 0.5 s late."""

RUNS_AWAY_AFTER_S = 1.0
"""Longest time in s to come to rest, with motion capture's delay."""

MOVES_M_S = 0.03
"""Speed in m/s above which a robot moves; motion capture shows less for one at rest."""

CREEPS_M_S, CREEPS_RAD_S = 0.005, 0.1
"""Forward speed (m/s) and turn rate (rad/s) above which wheels turn. A TurtleBot3 counts 4096
steps of 0.05 mm a turn, 20 times a second: at rest it shows 0.001 m/s at most, and its slowest
command is 0.01 m/s. Its turn rate is the gyroscope's, whose offset is below 5 deg/s (MPU-9250)."""

STOPS_CREEPING_WITHIN_S = 2.0
"""Longest time in s until wheels that turn slowly come to rest."""

_RESTS_FOR_S = 0.5  # a failed reading repeats the last position, as if the wheels rested
_MEASUREMENTS = 6  # of wheels that go on: the robot's computer may be late
_SLOWER = 0.8  # share of the speed before
_COMMANDED_M_S = 0.05
_SILENT_AFTER_S = 1.0
_OLD_S = 0.3  # largest age of wheels that turn


def wheels_turn(V: float, omega: float) -> bool:
    """Return whether odometry (m/s, rad/s) is of wheels that turn, not the noise of a rest."""
    return abs(V) > CREEPS_M_S or abs(omega) > CREEPS_RAD_S


class Obedience:
    """Compares commands with the speed of the wheels; all times in s on a steady clock.

    Attributes:
        came_to_rest: Whether the wheels have rested since the last command to move.
    """

    def __init__(self, limits: VelocityLimits, slows_within: float = SLOWS_WITHIN_S) -> None:
        """Start without a measurement of wheels, which slow down within a time (s)."""
        self.came_to_rest = False
        self._limits = limits
        self._slows_within = slows_within
        self._wheels = 0.0
        self._turning = False
        self._resting_since = math.inf
        self._measured: float | None = None
        self._follows = self._stops = 0.0  # when it last did as commanded
        self._zero_since = 0.0
        self._before = 0.0  # their fastest speed since then
        self._nb_measured = 0  # since then

    def measure(self, V: float, omega: float, now: float) -> None:
        """Note the forward speed (m/s) and the turn rate (rad/s) of the wheels.

        NaN measures nothing: if nothing else comes, they count as silent.
        """
        if self._measured is None:
            self._follows = self._stops = self._zero_since = self._measured = now
        if not (math.isfinite(V) and math.isfinite(omega)):
            return
        self._wheels, self._measured = self._limits.faster_wheel(V, omega), now
        self._turning = wheels_turn(V, omega)
        self._resting_since = math.inf if self._turning else min(self._resting_since, now)
        self._nb_measured += 1

    def update(self, V: float, omega: float, now: float) -> Disobedience | None:
        """Note the last command (m/s, rad/s); return how wheels disobey; None if they obey."""
        if self._measured is None:
            return None
        if now - self._measured > _SILENT_AFTER_S:
            self._follows = self._stops = self._zero_since = now
            self.came_to_rest = False
            return Disobedience.SILENT
        if self._turning or self._limits.faster_wheel(V, omega) <= _COMMANDED_M_S:
            self._follows = now
        ignores_zero = self._ignores_zero(V, omega, now, self._measured)
        if now - self._follows > FOLLOWS_WITHIN_S:
            return Disobedience.DOES_NOT_TURN
        return Disobedience.IGNORES_ZERO if ignores_zero else None

    def _ignores_zero(self, V: float, omega: float, now: float, measured: float) -> bool:
        moves = V != 0.0 or omega != 0.0
        is_judged = not moves and now - measured <= _OLD_S
        if not is_judged:
            self._zero_since = now
        if not is_judged or self._wheels <= MOVES_M_S:
            self._stops, self._before, self._nb_measured = now, 0.0, 0
        self._before = max(self._before, self._wheels)
        rested = measured - max(self._resting_since, self._zero_since) >= _RESTS_FOR_S
        self.came_to_rest = not moves and (self.came_to_rest or rested)
        # A robot that came to rest has obeyed; a person may turn it slowly by hand.
        if not self.came_to_rest and now - self._zero_since > STOPS_CREEPING_WITHIN_S:
            return True
        has_slowed = self._wheels < _SLOWER * self._before
        patience = RUNS_AWAY_AFTER_S if has_slowed else self._slows_within
        return now - self._stops > patience and self._nb_measured >= _MEASUREMENTS
