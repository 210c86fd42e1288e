"""The velocities that control laws asked for, `commands.csv`: t, robot, vx, vy."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from setcmas_simu.arrays import Floats
from setcmas_tools.records.csv_files import read_rows, write_lines
from setcmas_tools.records.fleet_table import stacked

FILE_NAME = 'commands.csv'
_COLUMNS = ('t', 'robot', 'vx', 'vy')


@dataclass(frozen=True)
class Commands:
    """A row for each command of each robot, sorted by time and then by robot.

    Attributes:
        t: Times in s from the first command of the run, shape (rows,).
        robot: Numbers of the robots, from 1, shape (rows,).
        vx: Velocities along x in m/s after saturation, shape (rows,).
        vy: The same along y, shape (rows,).
    """

    t: Floats
    robot: NDArray[np.int64]
    vx: Floats
    vy: Floats

    def of(self, robot: int) -> Commands:
        """Return the rows of one robot."""
        mine = self.robot == robot
        return Commands(self.t[mine], self.robot[mine], self.vx[mine], self.vy[mine])

    def stacked(self) -> tuple[Floats, Floats] | None:
        """Return the times, shape (C,), and rows vx, vy of N robots, shape (C, 2, N).

        Returns:
            None if the robots have commands at times of their own.
        """
        found = stacked(self.t, self.robot, self.vx, self.vy)
        return (found[0][:, 0], np.stack(found[1:], axis=1)) if found else None


def commands(rows: ArrayLike) -> Commands:
    """Return the commands of rows t, robot, vx, vy in any order, shape (rows, 4)."""
    values = np.asarray(rows, dtype=float).reshape(-1, len(_COLUMNS))
    t, robot, vx, vy = values[np.lexsort((values[:, 1], values[:, 0]))].T
    return Commands(t, robot.astype(np.int64), vx, vy)


def write_csv(given: Commands, path: Path) -> None:
    """Write commands: t with 6 decimals, velocities with 9.

    Raises:
        OSError: The file cannot be written.
    """
    columns = (column.tolist() for column in (given.t, given.robot, given.vx, given.vy))
    write_lines(path, _COLUMNS, map('{:.6f},{:d},{:.9f},{:.9f}\n'.format, *columns))


def read_csv(path: Path) -> Commands | None:
    """Read commands; None if there is no such file.

    Raises:
        SetcmasError: The file cannot be read or is damaged.
    """
    rows = read_rows(path, _COLUMNS, lambda cells: list(map(float, cells)))
    return None if rows is None else commands(rows)
