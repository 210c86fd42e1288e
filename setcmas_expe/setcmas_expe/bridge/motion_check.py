"""Check of a robot's measured motion against its commands: finds plausible but wrong poses."""

from __future__ import annotations

import cmath
import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.fleet.planar_pose import Pose, wrap_angle

_STILL_SHARE = 0.4  # of the commanded motion, below which a robot has not moved
_OFF_HEADING_DEG = 25.0
_BACKWARDS_DEG = 150.0
_FASTER = 1.3  # times the commanded motion: more than a push or drift at rest explains
_SEEN_M = 0.005  # shortest displacement whose direction is known
_STILL_M = 0.02
_STILL_RAD = 0.1
_ZERO_M_S = 0.005  # shown as 0.00 m/s
_ZERO_RAD_S = 0.05


_STANDSTILL = (
    'does not move as commanded: have its markers fallen off, or is it lifted, blocked or '
    'switched off?'
)
_OTHER_WHEELS = 'is it another model, are its wheels of another size'


@dataclass(frozen=True)
class Deviation:
    """Measured and commanded motion over some time.

    Attributes:
        seconds: Duration in s.
        moved: Measured displacement in m: ahead, and to the left as imaginary part.
        commanded: Commanded displacement, likewise.
        turned: Measured turn in rad.
        commanded_turn: Commanded turn in rad.
        in_heading: Whether the turn deviates more than the displacement.
    """

    seconds: float
    moved: complex
    commanded: complex
    turned: float
    commanded_turn: float
    in_heading: bool

    @property
    def is_none(self) -> bool:
        """Whether the robot is at rest as commanded: the deviation is over."""
        speed = max(abs(self.moved), abs(self.commanded)) / self.seconds
        rate = max(abs(self.turned), abs(self.commanded_turn)) / self.seconds
        return speed < _ZERO_M_S and rate < _ZERO_RAD_S

    def text(self, proved: bool) -> str:
        """Return the deviation and advice, as text; a proved robot has the right axes."""
        if self._is_still() and (proved or not self.in_heading):
            return _STANDSTILL
        if self.in_heading:
            return self._heading(proved)
        wanted, got = abs(self.commanded), abs(self.moved)
        if wanted > _SEEN_M and 0.5 * wanted < got < 2.0 * wanted:
            off = math.degrees(cmath.phase(self.moved / self.commanded))
            if abs(off) > (_BACKWARDS_DEG if proved else _OFF_HEADING_DEG):
                return (
                    f'moves {round(off):+d} deg off its heading: is its body turned, are its axes '
                    'or y_up wrong, or is it another robot?'
                )
        return self._glides()

    def _is_still(self) -> bool:
        way, turn = abs(self.commanded), abs(self.commanded_turn)
        still = abs(self.moved) <= max(_STILL_M, _STILL_SHARE * way)
        still &= abs(self.turned) <= max(_STILL_RAD, _STILL_SHARE * turn)
        return still and (way > _STILL_M or turn > _STILL_RAD)

    def _heading(self, proved: bool) -> str:
        rate, commanded = self.turned / self.seconds, self.commanded_turn / self.seconds
        check = 'is its body symmetric or loose, or was it turned by hand?'
        if not proved and abs(self.turned) <= _STILL_SHARE * abs(self.commanded_turn):
            check = 'is y_up wrong in the lab file, is it held, or is it another robot?'
        elif self.turned * self.commanded_turn < 0 and abs(self.turned) > _STILL_RAD:
            check = 'are its axes mirrored (y_up in the lab file), or is it another robot?'
        elif self.turned * self.commanded_turn > _FASTER * self.commanded_turn**2 > 0:
            check = f'{_OTHER_WHEELS}, or was it turned by hand?'
        return f'turns at {rate:+.1f} rad/s, commanded {commanded:+.1f}: {check}'

    def _glides(self) -> str:
        speed, commanded = abs(self.moved) / self.seconds, abs(self.commanded) / self.seconds
        check = 'does motion capture drift, or was it pushed?'
        if self.commanded and (self.moved / self.commanded).real > _FASTER:
            check = f'{_OTHER_WHEELS}, {check}'
        return f'moves at {speed:.2f} m/s, commanded {commanded:.2f}: {check}'


Floats = NDArray[np.float64]

DELAYS_S = np.array([0.0, 0.1, 0.2, 0.3])
"""Possible delays from a command to its effect in motion capture, in s."""

WINDOWS_S = (0.5, 2.0)
"""Times over which motion is compared, in s: one for fast deviations, one for slow ones."""

_MARGIN_M = 0.03
_CRAWL_MARGIN_M = 0.02
_MARGIN_RAD = 0.3
_SLOW_MARGIN_RAD = 0.15
_SHARE = 0.2  # of the commanded way: slip, wheels' radii, whole hundredths
_OFF_AXLE_M = 0.06  # per rad turned, up to 1: the body's middle is not above the axle
_IN_A_ROW = 2
_SAME_M = 0.008  # largest difference from another robot's commanded motion to be that robot
_LIKELY = 1  # index of the likely delay
_LONGEST_STEP_S = 0.2


@dataclass(frozen=True)
class _Row:
    """Sums of measured and commanded motion up to a time.

    Attributes:
        time: When the pose was seen, in s.
        place: x + iy in m.
        heading: Heading in rad, not wrapped.
        ways: For each delay, the sum of the commanded displacements along the measured heading.
        turns: For each delay, the commanded angle in rad.
        driven: For each delay, the commanded distance in m.
    """

    time: float
    place: complex
    heading: float
    ways: NDArray[np.complex128]
    turns: Floats
    driven: Floats


class MotionCheck:
    """Compares over half a second and over two; all times in s on one steady clock.

    The delay from a command to its measurement is unknown, so motion is wrong only if no delay
    explains it. The prediction is the unicycle's along the measured heading.

    Attributes:
        advanced: How far the last step took the robot in the commanded direction, in m.
        turned: By which angle it turned in the commanded direction, in rad.
    """

    def __init__(self) -> None:
        self._rows: deque[_Row] = deque()
        self._commands: deque[tuple[float, float, float]] = deque()
        self._stepped = self._seen = -math.inf
        self._heading = 0.0
        self.forget()

    def forget(self) -> None:
        """Forget the past: the robot is paused, and may be carried."""
        self._rows.clear()
        self._commands.clear()
        self._ways = np.zeros(len(DELAYS_S), complex)
        self._turns = self._driven = np.zeros(len(DELAYS_S))
        self._in_a_row = 0
        self.advanced = self.turned = 0.0

    def command(self, V: float, omega: float, now: float) -> None:
        """Note the robot's command (m/s, rad/s) from now on."""
        self._commands.append((now, V, omega))
        while self._commands[0][0] < now - WINDOWS_S[-1] - DELAYS_S[-1]:
            self._commands.popleft()

    def step(
        self,
        pose: Pose,
        seen: float,
        now: float,
        crawls: bool,
        turns_slowly: bool,
    ) -> Deviation | None:
        """Add up until now, and judge the newest pose.

        Args:
            pose: The newest good pose (m, rad).
            seen: When it was measured, in s.
            now: Time in s.
            crawls: Whether the robot must still prove its way: the check of that is stricter.
            turns_slowly: Whether it must still prove its turning, likewise.

        Returns:
            The deviation; None if there is none, or no new pose.
        """
        self._heading += float(wrap_angle(pose[2] - self._heading))
        self._add_up(min(max(0.0, now - self._stepped), _LONGEST_STEP_S), now)
        self._stepped, self.advanced, self.turned = now, 0.0, 0.0
        if seen <= self._seen:
            return None
        self._seen = seen
        place = complex(*pose[:2])
        newest = _Row(seen, place, self._heading, self._ways, self._turns, self._driven)
        if self._rows:
            V, omega = self._speeds(seen)
            way = np.sign(V[V != 0.0][:1]).sum()
            turn = np.sign(omega[abs(omega) > _ZERO_RAD_S][:1]).sum()
            moved = (place - self._rows[-1].place) / cmath.rect(1.0, self._heading)
            self.advanced = float(moved.real * way)
            self.turned = float((self._heading - self._rows[-1].heading) * turn)
        self._rows.append(newest)
        while self._rows[0].time < seen - WINDOWS_S[-1]:
            self._rows.popleft()
        metres = _CRAWL_MARGIN_M if crawls else _MARGIN_M
        radians = _SLOW_MARGIN_RAD if turns_slowly else _MARGIN_RAD
        found = self._deviation(newest, metres, radians)
        self._in_a_row = self._in_a_row + 1 if found else 0
        return found if self._in_a_row >= _IN_A_ROW else None

    def explains(self, other: MotionCheck) -> bool:
        """Return whether this robot's commands explain another robot's motion."""
        if len(rows := other._rows) < 2:
            return False
        times, headings = np.array([(row.time, row.heading) for row in rows]).T
        steps = np.diff(times)
        V, omega = np.array([self._speeds(time) for time in times[1:]]).transpose(1, 2, 0)
        ways = (steps * V * np.exp(1j * headings[1:])).sum(axis=1)
        turns, driven = (steps * omega).sum(axis=1), (steps * abs(V)).sum(axis=1)
        fits = driven > 2 * _SAME_M
        fits &= abs(rows[-1].place - rows[0].place - ways) <= _SAME_M + _SHARE * driven
        fits &= abs(headings[-1] - headings[0] - turns) <= _MARGIN_RAD + _SHARE * abs(turns)
        return bool(fits.any())

    def _add_up(self, step: float, now: float) -> None:
        V, omega = self._speeds(now)
        self._ways = self._ways + step * V * cmath.rect(1.0, self._heading)
        self._turns = self._turns + step * omega
        self._driven = self._driven + step * abs(V)

    def _speeds(self, time: float) -> tuple[Floats, Floats]:
        """Return the commanded V and omega that may take effect at a time, for each delay."""
        V, omega = np.array([self._commanded(time - delay) for delay in DELAYS_S]).T
        return V, omega

    def _commanded(self, time: float) -> tuple[float, float]:
        """Return the commanded speeds at a time; zero before the first command."""
        for since, V, omega in reversed(self._commands):
            if since <= time:
                return V, omega
        return 0.0, 0.0

    def _deviation(self, newest: _Row, metres: float, radians: float) -> Deviation | None:
        """Return how the measured motion differs from the commands at any delay."""
        for window in WINDOWS_S:
            old = self._row(newest.time - window)
            if self._excess(old, newest, metres, radians) > 1.0:
                # Describe the second half: the motion may have been right before.
                deviation = self._between(self._row(newest.time - 0.5 * window), newest)
                if not deviation.is_none:
                    return deviation
        return None

    def _row(self, since: float) -> _Row:
        return next(row for row in self._rows if row.time >= since)

    def _excess(self, old: _Row, new: _Row, metres: float, radians: float) -> float:
        """Return the difference as a multiple of its tolerance, for the delay that fits best."""
        moved, turned = new.place - old.place, new.heading - old.heading
        turns = new.turns - old.turns
        places = metres + _OFF_AXLE_M * min(1.0, abs(turned)) + _SHARE * (new.driven - old.driven)
        off = abs(moved - new.ways + old.ways) / places
        astray = abs(turned - turns) / (radians + _SHARE * abs(turns))
        return float(np.maximum(off, astray).min())

    def _between(self, old: _Row, new: _Row) -> Deviation:
        ahead = cmath.rect(1.0, old.heading)
        moved = (new.place - old.place) / ahead
        commanded = complex(new.ways[_LIKELY] - old.ways[_LIKELY]) / ahead
        turned, turn = new.heading - old.heading, float(new.turns[_LIKELY] - old.turns[_LIKELY])
        return Deviation(
            seconds=max(new.time - old.time, 1e-3),
            moved=moved,
            commanded=commanded,
            turned=turned,
            commanded_turn=turn,
            in_heading=abs(turned - turn) / _MARGIN_RAD > abs(moved - commanded) / _MARGIN_M,
        )
