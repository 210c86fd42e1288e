"""Record of the communication of a fleet: messages of each link, triggers and graph."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import NamedTuple

import numpy as np

from setcmas_ctrl.communication.message_content import Value, plain
from setcmas_simu.arrays import Floats


@dataclass(frozen=True)
class Counts:
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
