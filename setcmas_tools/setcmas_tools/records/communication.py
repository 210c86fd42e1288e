"""Record of the messages on each link: communication.csv, triggers.csv and graph.csv."""

from __future__ import annotations

import csv
import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError

COUNTS_FILE = 'communication.csv'
TRIGGERS_FILE = 'triggers.csv'
GRAPH_FILE = 'graph.csv'
FILE_NAMES = (COUNTS_FILE, TRIGGERS_FILE, GRAPH_FILE)

_COUNTS = ('sender', 'receiver', 'sent', 'received', 'lost', 'mean_interval')
_TRIGGERS = ('t', 'robot', 'sent')
_GRAPH = ('t', 'receiver', 'sender', 'weight')
_ALL = 'all'


@dataclass(frozen=True)
class Counts:
    """Messages of a link, or of a robot: what it broadcast, and how that arrived at the others.

    Attributes:
        sent: How many were sent.
        received: How many arrived; those of a robot count once for each that received them.
        lost: How many were lost.
        mean_interval: Mean time in s between arrivals (of a link) or broadcasts (of a robot);
            NaN for fewer than two.
    """

    sent: int
    received: int
    lost: int
    mean_interval: float


@dataclass(frozen=True)
class CommunicationRecord:
    """What went over the links of a fleet in a run.

    Attributes:
        robots: Counts of each robot.
        links: Counts of each link that was up at some time, by (receiver, sender).
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
        """Whether robots sent their state only when a condition triggered."""
        return len(self.triggers) > 0

    @property
    def trigger_times(self) -> dict[int, Floats]:
        """Times in s at which each robot sent its state; empty if communication was periodic."""
        robots, sent = self.triggers[:, 1], self.triggers[:, 2] == 1
        return {
            int(robot): self.triggers[sent & (robots == robot), 0] for robot in np.unique(robots)
        }

    def adjacency(self, t: float, nb_robots: int) -> Floats:
        """Return the weights at time t (s): row i hears column j, shape (N, N)."""
        result = np.zeros((nb_robots, nb_robots))
        for _, receiver, sender, weight in self.changes[self.changes[:, 0] <= t]:
            result[int(receiver) - 1, int(sender) - 1] = weight
        return result


def record_of(
    links: Mapping[tuple[int, int], Counts],
    triggers: Iterable[tuple[float, int, int]],
    changes: Iterable[tuple[float, int, int, float]],
    broadcasts: Mapping[int, Floats],
) -> CommunicationRecord:
    """Return the record of a run.

    Args:
        links: Counts of each link.
        triggers: Rows in any order.
        changes: Rows in any order.
        broadcasts: Times in s at which each robot sent its state, if communication was periodic.
    """
    rows = _sorted(triggers, len(_TRIGGERS))
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
    return CommunicationRecord(
        robots, dict(sorted(links.items())), rows, _sorted(changes, len(_GRAPH))
    )


def _mean_interval(times: Floats) -> float:
    return float(times[-1] - times[0]) / (len(times) - 1) if len(times) > 1 else math.nan


def _sorted(rows: Iterable[tuple[float, ...]], nb_columns: int) -> Floats:
    table = np.array(list(rows), dtype=float).reshape(-1, nb_columns)
    return table[np.lexsort(table.T[::-1])]


def write_csv(record: CommunicationRecord, folder: Path) -> None:
    """Write the files of a record; equal records give equal files.

    Raises:
        OSError: A file cannot be written.
    """
    robots = [(robot, _ALL, counts) for robot, counts in record.robots.items()]
    links = [(sender, receiver, counts) for (receiver, sender), counts in record.links.items()]
    _write(
        folder / COUNTS_FILE,
        _COUNTS,
        (
            f'{sender},{receiver},{c.sent},{c.received},{c.lost},{_seconds(c.mean_interval)}'
            for sender, receiver, c in [*robots, *links]
        ),
    )
    if record.is_event_triggered:
        rows = (f'{t:.6f},{robot:.0f},{sent:.0f}' for t, robot, sent in record.triggers.tolist())
        _write(folder / TRIGGERS_FILE, _TRIGGERS, rows)
    rows = (
        f'{t:.6f},{receiver:.0f},{sender:.0f},{weight:.9g}'
        for t, receiver, sender, weight in record.changes.tolist()
    )
    _write(folder / GRAPH_FILE, _GRAPH, rows)


def _seconds(value: float) -> str:
    return f'{value:.6f}' if math.isfinite(value) else ''


def _write(path: Path, columns: tuple[str, ...], rows: Iterable[str]) -> None:
    with path.open('w', encoding='utf-8', newline='') as file:
        file.write(','.join(columns) + '\n')
        file.writelines(f'{row}\n' for row in rows)


def read_csv(folder: Path) -> CommunicationRecord | None:
    """Read the record of a run from the folder of its CSV files; None if it has none.

    Raises:
        SetcmasError: A file cannot be read or is damaged.
    """
    if not (folder / COUNTS_FILE).is_file():
        return None
    robots: dict[int, Counts] = {}
    links: dict[tuple[int, int], Counts] = {}
    for sender, receiver, counts in _read(folder / COUNTS_FILE, _COUNTS, _counts):
        if receiver == _ALL:
            robots[sender] = counts
        else:
            links[int(receiver), sender] = counts
    tables = [
        np.array(_read(folder / name, columns, parsed), dtype=float).reshape(-1, len(columns))
        if (folder / name).is_file()
        else np.empty((0, len(columns)))
        for name, columns, parsed in (
            (TRIGGERS_FILE, _TRIGGERS, _trigger),
            (GRAPH_FILE, _GRAPH, _change),
        )
    ]
    return CommunicationRecord(robots, links, *tables)


def _counts(cells: list[str]) -> tuple[int, str, Counts]:
    sender, receiver, sent, received, lost, interval = cells
    if receiver != _ALL:
        _robot(receiver)
    return (
        _robot(sender),
        receiver,
        Counts(int(sent), int(received), int(lost), float(interval or 'nan')),
    )


def _trigger(cells: list[str]) -> tuple[float, int, int]:
    t, robot, sent = cells
    return float(t), _robot(robot), int(sent)


def _change(cells: list[str]) -> tuple[float, int, int, float]:
    t, receiver, sender, weight = cells
    return float(t), _robot(receiver), _robot(sender), float(weight)


def _robot(cell: str) -> int:
    if (robot := int(cell)) < 1:
        raise ValueError
    return robot


def _read(path: Path, columns: tuple[str, ...], parsed: Callable[[list[str]], Any]) -> list[Any]:
    try:
        with path.open(encoding='utf-8-sig', newline='') as file:
            header, *rows = csv.reader(file)
            if tuple(header) != columns or any(len(row) != len(columns) for row in rows):
                raise ValueError
            return [parsed(row) for row in rows]
    except (OSError, UnicodeDecodeError, csv.Error, ValueError) as error:
        raise SetcmasError(
            f"'{path}' is damaged; it must have the columns {','.join(columns)}"
        ) from error
