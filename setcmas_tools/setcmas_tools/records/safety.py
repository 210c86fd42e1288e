"""What the safety of an experiment let robots do, `safety.csv`: t, robot, state, overruled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats
from setcmas_tools.records.csv_files import read_rows, write_lines

FILE_NAME = 'safety.csv'
MOVING = 'moving'
"""The state of a robot that is free to move; others are paused and stopped."""

_COLUMNS = ('t', 'robot', 'state', 'overruled')

Row = tuple[float, int, str, bool]


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


def safety_record(rows: Sequence[Row]) -> SafetyRecord:
    """Return the record of rows in any order."""
    ordered = sorted(rows)
    return SafetyRecord(
        np.array([t for t, *_ in ordered]),
        np.array([robot for _, robot, *_ in ordered], dtype=np.int64),
        [state for *_, state, _ in ordered],
        np.array([overruled for *_, overruled in ordered], dtype=bool),
    )


def write_csv(record: SafetyRecord, path: Path) -> None:
    """Write a record: t with 6 decimals.

    Raises:
        OSError: The file cannot be written.
    """
    columns = (record.t.tolist(), record.robot.tolist(), record.state, record.overruled.tolist())
    write_lines(path, _COLUMNS, map('{:.6f},{:d},{},{:d}\n'.format, *columns))


def read_csv(path: Path) -> SafetyRecord | None:
    """Read a record; None if there is no such file.

    Raises:
        SetcmasError: The file cannot be read or is damaged.
    """
    rows = read_rows(path, _COLUMNS, _row)
    return None if rows is None else safety_record(rows)


def _row(cells: list[str]) -> Row:
    t, robot, state, overruled = cells
    return float(t), int(robot), state, bool(int(overruled))
