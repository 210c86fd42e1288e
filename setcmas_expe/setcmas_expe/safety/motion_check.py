"""Check of a robot's measured motion against what it was commanded: plausible, wrong poses."""

from __future__ import annotations

import cmath
import itertools
import math
from collections import deque
from dataclasses import dataclass

from setcmas_expe.mocap.sample import Pose
from setcmas_simu.fleet.planar_pose import wrap_angle

_STANDS = 0.4  # share of what was commanded below which nothing has moved
_BESIDE_RAD = math.radians(25)
_STILL_M = 0.02
_STILL_RAD = 0.1
_ZERO_M_S = 0.005  # what people are told as 0.00 m/s
_ZERO_RAD_S = 0.05


@dataclass(frozen=True)
class Deviation:
    """What motion capture showed over some time, and what was commanded.

    Attributes:
        seconds: How long.
        moved: Measured displacement in m: ahead, and to the left as imaginary part.
        commanded: The displacement that was commanded, likewise.
        turned: Measured turn in rad.
        commanded_turn: The turn that was commanded in rad.
        in_heading: Whether the turn deviates more than the displacement.
        rolled: Distance by the wheels' odometry in m; None if it is not known.
    """

    seconds: float
    moved: complex
    commanded: complex
    turned: float
    commanded_turn: float
    in_heading: bool
    rolled: float | None

    @property
    def is_none(self) -> bool:
        """Whether the robot stands and was told to: something was odd before, not now."""
        speed = max(abs(self.moved), abs(self.commanded)) / self.seconds
        rate = max(abs(self.turned), abs(self.commanded_turn)) / self.seconds
        return speed < _ZERO_M_S and rate < _ZERO_RAD_S

    def told(self, proved: bool) -> str:
        """Return what is wrong, and where to look; a robot that is proved has the right axes."""
        if self._stands():
            return self._standstill()
        if self.in_heading:
            return self._heading()
        wanted, got = abs(self.commanded), abs(self.moved)
        if not proved and wanted > _STILL_M and 0.5 * wanted < got < 2.0 * wanted:
            off = math.degrees(cmath.phase(self.moved / self.commanded))
            if abs(off) > math.degrees(_BESIDE_RAD):
                return (
                    f'it moves {round(off):+d} deg beside its heading: are the axes of its body, '
                    'or y_up, wrong, or is it another robot?'
                )
        return self._glides()

    def _stands(self) -> bool:
        way, turn = abs(self.commanded), abs(self.commanded_turn)
        still = abs(self.moved) <= max(_STILL_M, _STANDS * way)
        still &= abs(self.turned) <= max(_STILL_RAD, _STANDS * turn)
        return still and (way > _STILL_M or turn > _STILL_RAD)

    def _standstill(self) -> str:
        if self.rolled is None:
            where = 'has its body fallen off, or is it lifted, blocked or switched off?'
        elif self.rolled > max(_STILL_M, _STANDS * abs(self.commanded)):
            where = 'its wheels turn: has its body fallen off, or is it lifted or blocked?'
        else:
            where = 'its wheels stand too: is it blocked, or its motors off?'
        return f'it stands although it is told to move; {where}'

    def _heading(self) -> str:
        rates = (self.turned / self.seconds, self.commanded_turn / self.seconds)
        if self.turned * self.commanded_turn < 0 and abs(self.turned) > _STILL_RAD:
            return (
                f'it turns at {rates[0]:+.1f} rad/s, told {rates[1]:+.1f}: are axes mirrored '
                '(y_up in the lab file), or is it another robot?'
            )
        return (
            f'it turns at {rates[0]:+.1f} rad/s, told {rates[1]:+.1f}: is its body symmetric or '
            'loose, or is it turned by hand?'
        )

    def _glides(self) -> str:
        speed, told = abs(self.moved) / self.seconds, abs(self.commanded) / self.seconds
        wheels = '' if self.rolled is None else f', its wheels {self.rolled / self.seconds:.2f}'
        return (
            f'it moves at {speed:.2f} m/s, told {told:.2f}{wheels}: does motion capture drift, or '
            'is it pushed?'
        )


DELAYS_S = (0.0, 0.1, 0.2, 0.3)
"""Times from a command to what motion capture shows of it, of which any may be true, in s."""

WINDOWS_S = (0.5, 2.0)
"""Times over which motion is compared, in s: what is fast, and what is slow."""

_MARGIN_M = 0.03
_CRAWL_MARGIN_M = 0.02
_MARGIN_RAD = 0.3
_SHARE = 0.2  # of the way that was commanded: slip, wheels' radii, whole hundredths
_OFF_AXLE_M = 0.06  # per rad turned, up to 1: the body's middle is not above the axle
_IN_A_ROW = 2
_SAME_M = 0.008  # a robot that moves as another one is told differs less from it
_LIKELY = 1  # of the delays
_LONGEST_STEP_S = 0.2
_WHEELS_S = 0.2  # age from which wheel odometry tells nothing of the wheels


@dataclass(frozen=True)
class _Row:
    """What had been measured and commanded by a time.

    Attributes:
        time: When the pose was seen, in s.
        place: x + iy in m.
        heading: Heading in rad, not wrapped.
        ways: For each delay, the sum of the commanded displacements along the measured heading.
        turns: For each delay, the angle that was commanded, in rad.
        driven: For each delay, the distance that was commanded, in m.
        wheels: The distance by the wheels' odometry, in m.
    """

    time: float
    place: complex
    heading: float
    ways: tuple[complex, ...]
    turns: tuple[float, ...]
    driven: tuple[float, ...]
    wheels: float


class MotionCheck:
    """Compares over half a second and over two; all times in s on one steady clock.

    Since nobody knows the delay from a command to its measurement, motion is wrong only if no
    delay explains it. The prediction is the unicycle's along the measured heading.

    Attributes:
        advanced: How far the robot has moved the way that it was told, by the last step, in m.
    """

    def __init__(self) -> None:
        """Begin without a past."""
        self._rows: deque[_Row] = deque()
        self._commands: deque[tuple[float, float, float]] = deque()
        self._wheels: tuple[float, float] | None = None
        self._wheels_turned = False
        self._stepped = self._seen = -math.inf
        self._heading = 0.0
        self.forget()

    def forget(self) -> None:
        """Forget what was: the robot is paused, and may be carried."""
        self._rows.clear()
        self._commands.clear()
        zeros = (0.0,) * len(DELAYS_S)
        self._ways: tuple[complex, ...] = zeros
        self._turns = self._driven = zeros
        self._rolled = 0.0
        self._in_a_row = 0
        self.advanced = 0.0

    def command(self, V: float, omega: float, now: float) -> None:
        """Note what the robot is commanded (m/s, rad/s) from now on."""
        self._commands.append((now, V, omega))
        while self._commands[0][0] < now - WINDOWS_S[-1] - DELAYS_S[-1]:
            self._commands.popleft()

    def note_wheels(self, V: float, now: float) -> None:
        """Note the forward speed (m/s) that the robot's own odometry tells."""
        self._wheels_turned = self._wheels_turned or V != 0.0
        self._wheels = V, now

    def step(self, pose: Pose, seen: float, crawls: bool, now: float) -> Deviation | None:
        """Add up until now, and judge the newest pose.

        Args:
            pose: The newest good pose (m, rad).
            seen: When it was measured, in s.
            crawls: Whether the robot is to prove who it is: it is judged more strictly then.
            now: Time in s.

        Returns:
            What is wrong with the motion; None if nothing, or if nothing new was seen.
        """
        self._heading += float(wrap_angle(pose[2] - self._heading))
        self._add_up(min(max(0.0, now - self._stepped), _LONGEST_STEP_S), now)
        self._stepped, self.advanced = now, 0.0
        if seen <= self._seen:
            return None
        self._seen = seen
        place = complex(*pose[:2])
        sums = self._ways, self._turns, self._driven, self._rolled
        newest = _Row(seen, place, self._heading, *sums)
        if self._rows:
            speeds = (self._commanded(seen - delay)[0] for delay in DELAYS_S)
            V = next(filter(None, speeds), 0.0)
            moved = (place - self._rows[-1].place) / cmath.rect(1.0, self._heading)
            self.advanced = moved.real * ((V > 0) - (V < 0))
        self._rows.append(newest)
        while self._rows[0].time < seen - WINDOWS_S[-1]:
            self._rows.popleft()
        found = self._deviation(newest, _CRAWL_MARGIN_M if crawls else _MARGIN_M)
        self._in_a_row = self._in_a_row + 1 if found else 0
        return found if self._in_a_row >= _IN_A_ROW else None

    def explains(self, other: MotionCheck) -> bool:
        """Return whether another robot moves as this one is commanded."""
        rows = list(other._rows)
        if len(rows) < 2:
            return False
        return any(self._fits(rows, delay) for delay in DELAYS_S)

    def _add_up(self, step: float, now: float) -> None:
        ahead = cmath.rect(1.0, self._heading)
        speeds = [self._commanded(now - delay) for delay in DELAYS_S]
        self._ways = tuple(
            way + step * V * ahead for way, (V, _) in zip(self._ways, speeds, strict=True)
        )
        self._turns = tuple(t + step * w for t, (_, w) in zip(self._turns, speeds, strict=True))
        self._driven = tuple(
            way + step * abs(V) for way, (V, _) in zip(self._driven, speeds, strict=True)
        )
        if self._wheels and now - self._wheels[1] < _WHEELS_S:
            self._rolled += step * abs(self._wheels[0])

    def _commanded(self, time: float) -> tuple[float, float]:
        """Return the speeds that were commanded at a time; zero before the first command."""
        for since, V, omega in reversed(self._commands):
            if since <= time:
                return V, omega
        return 0.0, 0.0

    def _deviation(self, newest: _Row, margin: float) -> Deviation | None:
        """Return how the measured motion differs from all that may have been commanded."""
        for window in WINDOWS_S:
            if self._excess(self._row(newest.time - window), newest, margin) > 1.0:
                # What is told is of the second half: the motion may have been right before.
                deviation = self._between(self._row(newest.time - 0.5 * window), newest)
                if not deviation.is_none:
                    return deviation
        return None

    def _row(self, since: float) -> _Row:
        return next(row for row in self._rows if row.time >= since)

    def _excess(self, old: _Row, new: _Row, margin: float) -> float:
        """Return how many times the difference is what may be, for the delay that fits best."""
        moved, turned = new.place - old.place, new.heading - old.heading
        places = margin + _OFF_AXLE_M * min(1.0, abs(turned))
        return min(
            max(
                abs(moved - new.ways[i] + old.ways[i])
                / (places + _SHARE * (new.driven[i] - old.driven[i])),
                abs(turned - new.turns[i] + old.turns[i])
                / (_MARGIN_RAD + _SHARE * abs(new.turns[i] - old.turns[i])),
            )
            for i in range(len(DELAYS_S))
        )

    def _between(self, old: _Row, new: _Row) -> Deviation:
        ahead = cmath.rect(1.0, old.heading)
        moved = (new.place - old.place) / ahead
        commanded = (new.ways[_LIKELY] - old.ways[_LIKELY]) / ahead
        turned, turn = new.heading - old.heading, new.turns[_LIKELY] - old.turns[_LIKELY]
        return Deviation(
            seconds=max(new.time - old.time, 1e-3),
            moved=moved,
            commanded=commanded,
            turned=turned,
            commanded_turn=turn,
            in_heading=abs(turned - turn) / _MARGIN_RAD > abs(moved - commanded) / _MARGIN_M,
            rolled=new.wheels - old.wheels if self._knows_wheels() else None,
        )

    def _knows_wheels(self) -> bool:
        return bool(
            self._wheels_turned and self._wheels and self._stepped - self._wheels[1] < _WHEELS_S
        )

    def _fits(self, rows: list[_Row], delay: float) -> bool:
        """Return whether rows of another robot fit what this one is commanded."""
        way, turn, driven = 0j, 0.0, 0.0
        for before, after in itertools.pairwise(rows):
            V, omega = self._commanded(after.time - delay)
            step = after.time - before.time
            way += step * V * cmath.rect(1.0, after.heading)
            turn += step * omega
            driven += step * abs(V)
        moved = rows[-1].place - rows[0].place
        turned = rows[-1].heading - rows[0].heading
        return (
            driven > 2 * _SAME_M
            and abs(moved - way) <= _SAME_M + _SHARE * driven
            and abs(turned - turn) <= _MARGIN_RAD + _SHARE * abs(turn)
        )
