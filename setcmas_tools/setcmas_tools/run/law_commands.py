"""Velocities that laws asked for, and what safety filter and safety of experiments allowed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from setcmas_simu.arrays import Floats
from setcmas_tools.run.fleet_motion import read_rows, stacked, write_lines

COMMANDS_FILE = 'commands.csv'
_COLUMNS = ('t', 'robot', 'vx', 'vy')
_OF_FILTER = ('allowed_vx', 'allowed_vy', 'verdict')

_EARLY_S = 0.001


@dataclass(frozen=True)
class Filtered:
    """What the safety filter let through, a row for each command.

    Attributes:
        vx: Velocities along x in m/s: what was wanted, or what took its place.
        vy: The same along y.
        verdict: What became of what was wanted, as `setcmas_ctrl.filter.barrier.Verdict` has it.
    """

    vx: Floats
    vy: Floats
    verdict: Floats

    def rows(self, which: NDArray[np.bool_]) -> Filtered:
        """Return some rows."""
        return Filtered(self.vx[which], self.vy[which], self.verdict[which])


@dataclass(frozen=True)
class Commands:
    """A row for each command of each robot, sorted by time and then by robot.

    Attributes:
        t: Times in s from the first command of the run, shape (rows,).
        robot: Numbers of the robots, from 1, shape (rows,).
        vx: Velocities along x in m/s after saturation, shape (rows,).
        vy: The same along y, shape (rows,).
        allowed: What the safety filter let through; None without a filter.
    """

    t: Floats
    robot: NDArray[np.int64]
    vx: Floats
    vy: Floats
    allowed: Filtered | None = None

    def of(self, robot: int) -> Commands:
        """Return the rows of one robot."""
        mine = self.robot == robot
        allowed = self.allowed and self.allowed.rows(mine)
        return Commands(self.t[mine], self.robot[mine], self.vx[mine], self.vy[mine], allowed)

    def stacked(self) -> tuple[Floats, Floats] | None:
        """Return the times, shape (C,), and rows vx, vy of N robots, shape (C, 2, N).

        Returns:
            None if the robots have commands at times of their own.
        """
        found = stacked(self.t, self.robot, self.vx, self.vy)
        return (found[0][:, 0], np.stack(found[1:], axis=1)) if found else None


def commands(rows: ArrayLike) -> Commands:
    """Return the commands of rows in any order, shape (rows, 4), or (rows, 7) with a filter."""
    values = np.asarray(rows, dtype=float)
    t, robot, vx, vy, *allowed = values[np.lexsort((values[:, 1], values[:, 0]))].T
    return Commands(t, robot.astype(np.int64), vx, vy, Filtered(*allowed) if allowed else None)


def with_allowed(wanted: Floats, allowed: Floats) -> Floats:
    """Return rows of commands with what the filter let through beside them, shape (rows, 7).

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


def write_commands(given: Commands, path: Path) -> None:
    """Write commands: t with 6 decimals, velocities with 9.

    Raises:
        OSError: The file cannot be written.
    """
    columns = [given.t, given.robot, given.vx, given.vy]
    names: tuple[str, ...] = _COLUMNS
    form = '{:.6f},{:d},{:.9f},{:.9f}'
    if given.allowed:
        columns += [given.allowed.vx, given.allowed.vy, given.allowed.verdict]
        form, names = f'{form},{{:.9f}},{{:.9f}},{{:.0f}}', names + _OF_FILTER
    lines = map(f'{form}\n'.format, *(column.tolist() for column in columns))
    write_lines(path, names, lines)


def read_commands(path: Path) -> Commands | None:
    """Read commands; None if there is no such file.

    Raises:
        SetcmasError: The file cannot be read or is damaged.
    """
    rows = read_rows(path, _COLUMNS, lambda cells: list(map(float, cells)), _OF_FILTER)
    return None if rows is None else commands(rows or np.empty((0, len(_COLUMNS))))


SAFETY_FILE = 'safety.csv'
MOVING = 'moving'
"""The state of a robot that is free to move; others are paused and stopped."""

_SAFETY_COLUMNS = ('t', 'robot', 'state', 'overruled')

SafetyRow = tuple[float, int, str, bool]


@dataclass(frozen=True)
class SafetyRecord:
    """A row for each status of each robot, sorted by time and then by robot.

    Attributes:
        t: Times in s from the start, shape (rows,).
        robot: Numbers of the robots, from 1, shape (rows,).
        state: What each was let do.
        overruled: Whether it was not free to do all that its law wanted, shape (rows,).
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


def write_safety(record: SafetyRecord, path: Path) -> None:
    """Write a record: t with 6 decimals.

    Raises:
        OSError: The file cannot be written.
    """
    columns = (record.t.tolist(), record.robot.tolist(), record.state, record.overruled.tolist())
    write_lines(path, _SAFETY_COLUMNS, map('{:.6f},{:d},{},{:d}\n'.format, *columns))


def read_safety(path: Path) -> SafetyRecord | None:
    """Read a record; None if there is no such file.

    Raises:
        SetcmasError: The file cannot be read or is damaged.
    """
    rows = read_rows(path, _SAFETY_COLUMNS, _safety_row)
    return None if rows is None else safety_record(rows)


def _safety_row(cells: list[str]) -> SafetyRow:
    t, robot, state, overruled = cells
    return float(t), int(robot), state, bool(int(overruled))
