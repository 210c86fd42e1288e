"""Deadlock: robots that want to move and stand for each other's sake."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.filter.clearance import NOBODY, Indices, Rows
from setcmas_simu.arrays import Floats

BLOCKED_S = 1.0
"""How long a robot stands before it counts as blocked, in s."""

_TOLD_S = 2.0  # a group must not change for so long
_STANDS = 0.1  # share of the wanted speed below which a robot stands
_SLOWEST = 0.01  # m/s: who wants less wants to stand
_TOUCHES = 0.01  # m/s
_TURNS_S = 0.4  # which a robot stands before it turns
_RIGHT = math.radians(80.0)
_STRAIGHT_S = 0.4  # for which its way is free before it goes on


class Now(NamedTuple):
    """A moment of control: its time and the period that begins, in s."""

    t: float
    period: float


@dataclass(frozen=True)
class Block:
    """Robots that block each other.

    Attributes:
        robots: Their numbers, sorted; one alone is blocked by who or what stands in its way.
        since: Since when, in s.
    """

    robots: tuple[int, ...]
    since: float

    def __str__(self) -> str:
        """Return what a user is told."""
        *others, last = map(str, self.robots)
        if not others:
            return f'robot {last} has been blocked since {self.since:.1f} s'
        robots = f'robots {", ".join(others)} and {last}'
        return f'{robots} have blocked each other since {self.since:.1f} s'


class DeadlockWatch:
    """Recognises who is blocked, and by whom.

    Attributes:
        standing_s: For how long each robot has stood although it wants to move, in s, shape (N,).
    """

    def __init__(self, nb_robots: int) -> None:
        """Begin with robots that are free."""
        self.standing_s: Floats = np.zeros(nb_robots)
        self._groups: dict[tuple[int, ...], float] = {}
        self._told: list[set[int]] = []

    @property
    def blocked(self) -> NDArray[np.bool_]:
        """Which robots are blocked, shape (N,)."""
        return self.standing_s > BLOCKED_S

    def look(self, wanted: Floats, allowed: Floats, rows: Rows, now: Now) -> list[Block]:
        """Take what robots want and may do; returns the blocks to tell of, each once.

        Args:
            wanted: Rows vx, vy in m/s, shape (2, N).
            allowed: The same of the points that are moved.
            rows: The constraints.
            now: Time and period.
        """
        speeds = np.hypot(wanted[0], wanted[1])
        stands = (speeds > _SLOWEST) & (np.hypot(allowed[0], allowed[1]) < _STANDS * speeds)
        self.standing_s = np.where(stands, self.standing_s + now.period, 0.0)
        if not self.blocked.any():
            self._groups = {}
            return []
        touching = rows.chosen(rows.excess(allowed) > -_TOUCHES)
        groups = self._linked(touching)
        self._groups = {group: self._groups.get(group, now.t) for group in groups}
        new = [
            group
            for group, since in self._groups.items()
            if now.t - since >= _TOLD_S and not any(told.issuperset(group) for told in self._told)
        ]
        self._told += map(set, new)
        end = now.t + now.period
        return [
            Block(one, max(0.0, end - float(self.standing_s[np.array(one) - 1].min())))
            for one in new
        ]

    def _linked(self, touching: Rows) -> list[tuple[int, ...]]:
        """Return the numbers of the blocked robots in groups that constraints link."""
        blocked = self.blocked
        linked = (touching.j != NOBODY) & blocked[touching.i] & blocked[touching.j]
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
    """Turns robots that stand to the right until their way is free: a roundabout of their own."""

    def __init__(self, nb_robots: int) -> None:
        """Begin with robots that go straight."""
        self._turns = np.zeros(nb_robots, dtype=bool)
        self._free_s: Floats = np.zeros(nb_robots)

    def turned(self, wanted: Floats, own: Indices) -> Floats:
        """Return the velocities (2, R) of some robots, to the right of what is wanted."""
        right = np.where(self._turns[own], _RIGHT, 0.0)
        cos, sin = np.cos(right), np.sin(right)
        vx, vy = wanted
        return np.stack([cos * vx + sin * vy, cos * vy - sin * vx])

    def look(self, wanted: Floats, standing_s: Floats, rows: Rows, now: Now) -> None:
        """Take what robots want and for how long they have stood, as `DeadlockWatch` knows it."""
        towards = rows.a[0] * wanted[0, rows.i] + rows.a[1] * wanted[1, rows.i]
        back = -rows.a[0] * wanted[0, rows.j] - rows.a[1] * wanted[1, rows.j]
        hindered = np.zeros(len(standing_s), dtype=bool)
        hindered[rows.i[towards > rows.b]] = True
        hindered[rows.j[(rows.j != NOBODY) & (back > rows.b)]] = True
        self._free_s = np.where(hindered, 0.0, self._free_s + now.period)
        self._turns |= standing_s > _TURNS_S
        self._turns &= self._free_s < _STRAIGHT_S
