"""Records of a run: commands of its laws, drawings, safety, messages and communication."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from setcmas_ctrl.communication.message_content import Value, plain
from setcmas_ctrl.filter.filter_options import Verdict
from setcmas_ctrl.laws.drawing import Sphere
from setcmas_simu.arrays import Floats
from setcmas_tools.run.fleet_motion import LARGEST, RobotTable

MARKER, TRAIL = 'marker', 'trail'
_EARLY_S = 0.001


@dataclass(frozen=True, repr=False, eq=False)
class Commands(RobotTable):
    """Velocities that the laws returned: a row for each call.

    Attributes:
        vx: Velocities along x in m/s after saturation.
        vy: The same along y.
    """

    vx: Floats
    vy: Floats


@dataclass(frozen=True, repr=False, eq=False)
class FilteredCommands(Commands):
    """The same, and the velocities that the safety filter allowed.

    Attributes:
        allowed_vx: Allowed velocities along x in m/s.
        allowed_vy: The same along y.
        verdict: Values of `Verdict` of the filter.
    """

    allowed_vx: Floats
    allowed_vy: Floats
    verdict: Floats

    @property
    def changed(self) -> NDArray[np.bool_]:
        """Whether the filter let the robot have another velocity than it wanted."""
        return np.greater_equal(self.verdict, Verdict.CHANGED)

    @property
    def unsolved(self) -> NDArray[np.bool_]:
        """Whether no velocity was safe."""
        return np.equal(self.verdict, Verdict.NO_SOLUTION)


def commands(*columns: ArrayLike) -> Commands:
    """Return the commands of columns t, robot, vx, vy in any order, and of a filter's if any."""
    return (FilteredCommands if len(columns) > 4 else Commands).in_order(*columns)


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


@dataclass(frozen=True, repr=False, eq=False)
class SafetyRecord(RobotTable):
    """States of the robots in an experiment: a row for each status.

    Attributes:
        state: Their states, such as MOVING.
        overruled: 1 if safety limited or paused the robot, else 0.
    """

    state: NDArray[Any]
    overruled: NDArray[Any]


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

    def trails(self, t: float) -> list[Drawing]:
        """Return the spheres added to trails up to a time in s."""
        return self._trails[: bisect_right(self._trails, t, key=itemgetter(0))]


def _is_usable(sphere: Sphere) -> bool:
    return all(abs(number) <= LARGEST for number in (*sphere[:4], *sphere.colour, sphere.alpha))


class Counts(NamedTuple):
    """Messages of a link, or broadcasts of a robot.

    Attributes:
        sent: Number of messages sent.
        received: Number that arrived; a broadcast counts once for each receiver.
        lost: Number of messages lost.
        mean_interval: Mean time in s between arrivals (of a link) or broadcasts (of a robot);
            NaN for fewer than two.
    """

    sent: int
    received: int
    lost: int
    mean_interval: float


class SentMessage(NamedTuple):
    """A value that the law of a robot sent.

    Attributes:
        t: Time in s from the first command of the run.
        robot: Number of the robot, from 1.
    """

    t: float
    robot: int
    value: Value


def agreement_time(messages: Sequence[SentMessage], nb_robots: int) -> float | None:
    """Return the time in s from which the laws of all robots send the same value.

    None if they do not at the end. Messages are sorted by time.
    """
    values: dict[int, str] = {}
    since = None
    for t, sent in groupby(messages, key=lambda one: one.t):
        values |= {one.robot: repr(plain(one.value)) for one in sent}
        agree = len(values) == nb_robots and len(set(values.values())) == 1
        since = (t if since is None else since) if agree else None
    return since


@dataclass(frozen=True)
class CommunicationRecord:
    """Messages on the links of a fleet in a run.

    Attributes:
        robots: Counts of each robot.
        links: Counts of each link that was ever up, by (receiver, sender).
        triggers: A row t (s), robot, sent (0 or 1) for each evaluation of a triggering condition,
            shape (E, 3), sorted by time; no row if communication was periodic.
        changes: A row t (s), receiver, sender, weight for each link whose weight changes at t,
            shape (M, 4), sorted by time.
    """

    robots: dict[int, Counts]
    links: dict[tuple[int, int], Counts]
    triggers: Floats
    changes: Floats

    @property
    def is_event_triggered(self) -> bool:
        """Whether robots sent their states only on triggers."""
        return len(self.triggers) > 0

    @property
    def trigger_times(self) -> dict[int, Floats]:
        """Times in s at which each robot sent its state; empty if communication was periodic."""
        robots, sent = self.triggers[:, 1], self.triggers[:, 2] == 1
        return {
            int(robot): self.triggers[sent & (robots == robot), 0] for robot in np.unique(robots)
        }

    @property
    def intervals(self) -> dict[int, Floats]:
        """Times in s between the states that each robot sent; empty likewise."""
        return {robot: np.diff(times) for robot, times in self.trigger_times.items()}

    def __repr__(self) -> str:
        """Return one line."""
        return f'CommunicationRecord({len(self.robots)} robots, {len(self.links)} links)'

    def adjacency(self, t: float, nb_robots: int) -> Floats:
        """Return the weights at time t (s): row i receives from column j, shape (N, N)."""
        result = np.zeros((nb_robots, nb_robots))
        changes = self.changes[: np.searchsorted(self.changes[:, 0], t, side='right')]
        receivers, senders = changes[:, 1:3].astype(int).T - 1
        result[receivers, senders] = changes[:, 3]  # the last change of a link holds
        return result


def record_of(
    links: Mapping[tuple[int, int], Counts],
    triggers: Iterable[tuple[float, int, int]] | Floats,
    changes: Iterable[tuple[float, int, int, float]],
    broadcasts: Mapping[int, Floats],
) -> CommunicationRecord:
    """Return the record of a run from the counts of its links, with rows in any order.

    `broadcasts` are the times in s at which each robot sent its state, if periodic.
    """
    rows = _sorted(triggers, 3)
    if len(rows):
        sent = rows[rows[:, 2] == 1]
        broadcasts = {int(i): sent[sent[:, 1] == i, 0] for i in np.unique(rows[:, 1])}
    received: Counter[int] = Counter()
    lost: Counter[int] = Counter()
    for (_, sender), counts in links.items():
        received[sender] += counts.received
        lost[sender] += counts.lost
    robots = {
        robot: Counts(len(times), received[robot], lost[robot], _mean_interval(times))
        for robot, times in sorted(broadcasts.items())
    }
    return CommunicationRecord(robots, dict(sorted(links.items())), rows, _sorted(changes, 4))


def _mean_interval(times: Floats) -> float:
    return float(times[-1] - times[0]) / (len(times) - 1) if len(times) > 1 else math.nan


def _sorted(rows: Iterable[tuple[float, ...]] | Floats, nb_columns: int) -> Floats:
    given = rows if isinstance(rows, np.ndarray) else list(rows)
    table = np.array(given, dtype=float).reshape(-1, nb_columns)
    return table[np.lexsort(table.T[::-1])]
