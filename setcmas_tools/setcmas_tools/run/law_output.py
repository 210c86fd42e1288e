"""Output of control laws: their commands, what filter and safety allowed, and their drawings."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from setcmas_ctrl.laws.drawing import Sphere
from setcmas_simu.arrays import Floats
from setcmas_tools.run.fleet_motion import LARGEST, rows_in_words

MARKER, TRAIL = 'marker', 'trail'
_EARLY_S = 0.001


@dataclass(frozen=True)
class Filtered:
    """Velocities that the safety filter allowed, a row for each command.

    Attributes:
        vx: Allowed velocities along x in m/s.
        vy: The same along y.
        verdict: Values of `Verdict` of the filter.
    """

    vx: Floats
    vy: Floats
    verdict: Floats


@dataclass(frozen=True)
class Commands:
    """A row for each command of each robot, sorted by time and then by robot.

    Attributes:
        t: Times in s from the first command of the run, shape (rows,).
        robot: Numbers of the robots, from 1, shape (rows,).
        vx: Velocities along x in m/s after saturation, shape (rows,).
        vy: The same along y, shape (rows,).
        allowed: Velocities that the safety filter allowed; None without a filter.
    """

    t: Floats
    robot: NDArray[np.int64]
    vx: Floats
    vy: Floats
    allowed: Filtered | None = None

    def __repr__(self) -> str:
        """Return one line."""
        return f'Commands({rows_in_words(self.t, np.unique(self.robot).tolist())})'

    def of(self, robot: int) -> Commands:
        """Return the rows of one robot."""
        mine = self.robot == robot
        own = (self.t[mine], self.robot[mine], self.vx[mine], self.vy[mine])
        every = self.allowed
        allowed = every and Filtered(every.vx[mine], every.vy[mine], every.verdict[mine])
        return Commands(*own, allowed)


def commands(rows: ArrayLike) -> Commands:
    """Return the commands of rows in any order, shape (rows, 4), or (rows, 7) with a filter."""
    values = np.asarray(rows, dtype=float)
    t, robot, vx, vy, *allowed = values[np.lexsort((values[:, 1], values[:, 0]))].T
    return Commands(t, robot.astype(np.int64), vx, vy, Filtered(*allowed) if allowed else None)


def with_allowed(wanted: Floats, allowed: Floats) -> Floats:
    """Return rows of commands with the velocities that the filter allowed, shape (rows, 7).

    Args:
        wanted: Rows t, robot, vx, vy, shape (rows, 4).
        allowed: Rows t, robot, vx, vy, verdict in order of time, shape (M, 5), each sent after
            its command and before the next one; without any, the rows stay as they are. A
            command without such a row counts as let through.
    """
    if not len(allowed):
        return wanted
    rows = np.column_stack([wanted, wanted[:, 2:], np.zeros(len(wanted))])
    for robot in np.unique(wanted[:, 1]):
        own = np.flatnonzero(wanted[:, 1] == robot)
        others = allowed[allowed[:, 1] == robot]
        t = wanted[own, 0]
        # Two topics may overtake each other by a little when they are recorded.
        early = np.minimum(np.diff(t, prepend=-np.inf) / 4, _EARLY_S)
        of, first = np.unique(
            np.searchsorted(t - early, others[:, 0], side='right'), return_index=True
        )
        known = of > 0
        rows[own[of[known] - 1], 4:] = others[first[known], 2:]
    return rows


MOVING = 'moving'
"""The state of a robot that is free to move; others are paused and stopped."""

SafetyRow = tuple[float, int, str, bool]


@dataclass(frozen=True)
class SafetyRecord:
    """A row for each status of each robot, sorted by time and then by robot.

    Attributes:
        t: Times in s from the start, shape (rows,).
        robot: Numbers of the robots, from 1, shape (rows,).
        state: Their states, such as MOVING.
        overruled: Whether safety limited or paused the robot, shape (rows,).
    """

    t: Floats
    robot: NDArray[np.int64]
    state: Sequence[str]
    overruled: NDArray[np.bool_]


def safety_record(rows: Sequence[SafetyRow]) -> SafetyRecord:
    """Return the record of rows in any order."""
    ordered = sorted(rows)
    return SafetyRecord(
        np.array([t for t, *_ in ordered]),
        np.array([robot for _, robot, *_ in ordered], dtype=np.int64),
        [state for *_, state, _ in ordered],
        np.array([overruled for *_, overruled in ordered], dtype=bool),
    )


class Drawing(NamedTuple):
    """A sphere that a script drew.

    Attributes:
        t: Time in s from the first command of the run.
        robot: Number of its robot.
        name: Name of its topic, such as 'wp_ref'.
        kind: MARKER, which replaces that of the same robot and name, or TRAIL.
    """

    t: float
    robot: int
    name: str
    kind: str
    sphere: Sphere


class DrawingRecord:
    """Collects drawings: a canvas for scripts that run without ROS.

    A marker that stays as it is counts once, however often it is drawn.

    Attributes:
        t: The time now, in s.
    """

    def __init__(self) -> None:
        self.t = 0.0
        self._drawings: list[Drawing] = []
        self._shown: dict[tuple[int, str], Sphere] = {}

    def show(self, robot: int, name: str, sphere: Sphere) -> None:
        """Add a marker, drawn now."""
        if self._shown.get((robot, name)) != sphere:
            self._shown[robot, name] = sphere
            self._drawings.append(Drawing(self.t, robot, name, MARKER, sphere))

    def extend_trail(self, robot: int, name: str, sphere: Sphere) -> None:
        """Add a sphere to a trail, now."""
        self._drawings.append(Drawing(self.t, robot, name, TRAIL, sphere))

    def drawings(self) -> list[Drawing]:
        """Return the drawings, sorted by time, then robot."""
        return sorted(self._drawings, key=itemgetter(0, 1))


class DrawnOverTime:
    """Drawings of a run by time.

    Attributes:
        shown: The visible drawings, sorted by time.
    """

    def __init__(self, drawings: Iterable[Drawing]) -> None:
        """Take drawings sorted by time; drop those that are NaN or too large."""
        self.shown = [drawing for drawing in drawings if _is_usable(drawing.sphere)]
        self._markers: dict[tuple[int, str], list[Drawing]] = {}
        self._trails: list[Drawing] = []
        for drawing in self.shown:
            if drawing.kind == MARKER:
                self._markers.setdefault((drawing.robot, drawing.name), []).append(drawing)
            else:
                self._trails.append(drawing)

    def markers(self, t: float) -> list[Drawing]:
        """Return the visible markers at a time in s."""
        last = ((own, bisect_right(own, t, key=itemgetter(0))) for own in self._markers.values())
        return [own[count - 1] for own, count in last if count]

    def trails(self, t: float, since: float = -math.inf) -> list[Drawing]:
        """Return the spheres added to trails after a time in s and up to another."""
        first, last = (bisect_right(self._trails, at, key=itemgetter(0)) for at in (since, t))
        return self._trails[first:last]


def _is_usable(sphere: Sphere) -> bool:
    return all(abs(number) <= LARGEST for number in (*sphere[:4], *sphere.colour, sphere.alpha))
