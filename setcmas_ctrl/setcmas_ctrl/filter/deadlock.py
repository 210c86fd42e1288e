"""Deadlock: finds robots that stop because of each other, and turns them out of the way."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.filter.barrier_constraints import NO_POINT, Constraints, Indices
from setcmas_simu.arrays import Floats

BLOCKED_S = 1.0
"""Time in s without moving after which a robot counts as blocked."""

_STABLE_S = 2.0  # a group is reported after this long without a change
_STOPPED = 0.1  # share of the wanted speed below which a robot counts as stopped
_SLOWEST = 0.01  # m/s: a law with a lower speed wants its robot to stop
_TOUCHES = 0.01  # m/s
_TURNS_S = 0.4  # time stopped before a robot starts its detour
_RIGHT = math.radians(80.0)
_STRAIGHT_S = 0.4  # time with a free path before it ends its detour


class Now(NamedTuple):
    """A control step: its time and period, in s."""

    t: float
    period: float


@dataclass(frozen=True)
class Block:
    """A group of robots that block each other.

    Attributes:
        robots: Their sorted numbers; a single robot is blocked by another robot or an obstacle.
        since: Start of the block in s.
    """

    robots: tuple[int, ...]
    since: float

    def __str__(self) -> str:
        *others, last = map(str, self.robots)
        if not others:
            return f'robot {last} has been blocked since {self.since:.1f} s'
        robots = f'robots {", ".join(others)} and {last}'
        return f'{robots} have blocked each other since {self.since:.1f} s'


class DeadlockWatch:
    """Finds blocked robots, and who blocks them.

    Attributes:
        stopped_s: How long each robot has been stopped although it wants to move, in s, shape
            (N,).
    """

    def __init__(self, nb_robots: int) -> None:
        self.stopped_s: Floats = np.zeros(nb_robots)
        self._groups: dict[tuple[int, ...], float] = {}
        self._reported: list[set[int]] = []

    @property
    def blocked(self) -> NDArray[np.bool_]:
        """Mask of the blocked robots, shape (N,)."""
        return self.stopped_s > BLOCKED_S

    def update(
        self, wanted: Floats, allowed: Floats, constraints: Constraints, now: Now
    ) -> list[Block]:
        """Update with wanted velocities (2, N) and allowed ones of control points, in m/s.

        Returns:
            New blocks, each once.
        """
        speeds = np.hypot(wanted[0], wanted[1])
        stopped = (speeds > _SLOWEST) & (np.hypot(allowed[0], allowed[1]) < _STOPPED * speeds)
        self.stopped_s = np.where(stopped, self.stopped_s + now.period, 0.0)
        if not self.blocked.any():
            self._groups = {}
            return []
        touching = constraints.selected(constraints.excess(allowed) > -_TOUCHES)
        groups = self._linked(touching)
        self._groups = {group: self._groups.get(group, now.t) for group in groups}
        new = [
            group
            for group, since in self._groups.items()
            if now.t - since >= _STABLE_S
            and not any(old.issuperset(group) for old in self._reported)
        ]
        self._reported += map(set, new)
        end = now.t + now.period
        return [
            Block(one, max(0.0, end - float(self.stopped_s[np.array(one) - 1].min())))
            for one in new
        ]

    def _linked(self, touching: Constraints) -> list[tuple[int, ...]]:
        """Return the numbers of the blocked robots in groups linked by constraints."""
        blocked = self.blocked
        linked = (touching.j != NO_POINT) & blocked[touching.i] & blocked[touching.j]
        i, j = touching.i[linked], touching.j[linked]
        label, before = np.arange(len(blocked)), np.zeros(0)
        while not np.array_equal(label, before):
            before = label.copy()
            np.minimum.at(label, i, before[j])
            np.minimum.at(label, j, before[i])
        return [
            tuple(int(column) + 1 for column in np.flatnonzero(blocked & (label == one)))
            for one in np.unique(label[blocked])
        ]


class Detour:
    """Turns stopped robots to the right until their way is free, as in a roundabout."""

    def __init__(self, nb_robots: int) -> None:
        self._turns = np.zeros(nb_robots, dtype=bool)
        self._free_s: Floats = np.zeros(nb_robots)

    def turned(self, wanted: Floats, own: Indices) -> Floats:
        """Return the velocities (2, R) of some robots, turned right from the wanted ones."""
        right = np.where(self._turns[own], _RIGHT, 0.0)
        cos, sin = np.cos(right), np.sin(right)
        vx, vy = wanted
        return np.stack([cos * vx + sin * vy, cos * vy - sin * vx])

    def update(
        self, wanted: Floats, stopped_s: Floats, constraints: Constraints, now: Now
    ) -> None:
        """Update with wanted velocities and times stopped, as in `DeadlockWatch`."""
        a, b, i, j = constraints.a, constraints.b, constraints.i, constraints.j
        towards = a[0] * wanted[0, i] + a[1] * wanted[1, i]
        back = -a[0] * wanted[0, j] - a[1] * wanted[1, j]
        way_blocked = np.zeros(len(stopped_s), dtype=bool)
        way_blocked[i[towards > b]] = True
        way_blocked[j[(j != NO_POINT) & (back > b)]] = True
        self._free_s = np.where(way_blocked, 0.0, self._free_s + now.period)
        self._turns |= stopped_s > _TURNS_S
        self._turns &= self._free_s < _STRAIGHT_S
