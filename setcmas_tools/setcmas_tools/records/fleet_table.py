"""The tidy table of a fleet's motion, `fleet.csv`: t, robot, x, y, theta, v, omega."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_tools.records.csv_files import write_lines

FILE_NAME = 'fleet.csv'
COLUMNS = ('t', 'robot', 'x', 'y', 'theta', 'v', 'omega')
_FORM = f'the columns {",".join(COLUMNS)}'


@dataclass(frozen=True)
class FleetTable:
    """A row for each odometry message of each robot, sorted by time and then by robot.

    Attributes:
        t: Times in s from the first command of the run, shape (rows,).
        robot: Numbers of the robots, from 1, shape (rows,).
        x: Positions in m, shape (rows,).
        y: Positions in m, shape (rows,).
        theta: Headings in rad, shape (rows,).
        v: Forward speeds in m/s, shape (rows,).
        omega: Turn rates in rad/s, shape (rows,).
    """

    t: Floats
    robot: NDArray[np.int64]
    x: Floats
    y: Floats
    theta: Floats
    v: Floats
    omega: Floats

    @property
    def robots(self) -> list[int]:
        """The numbers of the robots, sorted."""
        return [int(robot) for robot in np.unique(self.robot)]

    def of(self, robot: int) -> FleetTable:
        """Return the rows of one robot."""
        return self.rows(self.robot == robot)

    def rows(self, selection: NDArray[np.bool_] | NDArray[np.intp]) -> FleetTable:
        """Return the rows that a mask, or indices, select."""
        return FleetTable(*(getattr(self, f.name)[selection] for f in fields(self)))

    def stacked(self) -> list[Floats] | None:
        """Return t, x, y, theta, v and omega, shape (K, N) each, of N robots at common times.

        Returns:
            None if the robots have rows at times of their own.
        """
        return stacked(self.t, self.robot, self.x, self.y, self.theta, self.v, self.omega)


def stacked(t: Floats, robot: NDArray[np.int64], *columns: Floats) -> list[Floats] | None:
    """Return times and columns, shape (K, N) each, of rows of N robots at K common times.

    Args:
        t: Times, sorted, shape (K N,).
        robot: Numbers of the robots, sorted at each time, shape (K N,).
        columns: Of the same shape.

    Returns:
        None if the robots have rows at times of their own.
    """
    robots = np.unique(robot)
    if not len(robots) or len(t) % len(robots):
        return None
    times = t.reshape(-1, len(robots))
    regular = (robot.reshape(-1, len(robots)) == robots).all()
    if not regular or (times != times[:, :1]).any():
        return None
    return [column.reshape(-1, len(robots)) for column in (t, *columns)]


def fleet_table(rows: ArrayLike) -> FleetTable:
    """Return the table of rows in any order.

    Args:
        rows: A row of t, robot, x, y, theta, v, omega for each sample, shape (rows, 7).
    """
    values = np.asarray(rows, dtype=float).reshape(-1, len(COLUMNS))
    t, robot, *rest = values[np.lexsort((values[:, 1], values[:, 0]))].T
    return FleetTable(t, robot.astype(np.int64), *rest)


def write_csv(table: FleetTable, path: Path) -> None:
    """Write a table: t with 6 decimals, the rest with 9, so that equal tables give equal files.

    Raises:
        OSError: The file cannot be written.
    """
    part = path.with_name(f'{path.name}.part')
    columns = [getattr(table, name).tolist() for name in COLUMNS]
    lines = (
        f'{t:.6f},{robot:d},{x:.9f},{y:.9f},{theta:.9f},{v:.9f},{omega:.9f}\n'
        for t, robot, x, y, theta, v, omega in zip(*columns, strict=True)
    )
    write_lines(part, COLUMNS, lines)
    part.replace(path)


def read_csv(path: Path) -> FleetTable:
    """Read a table.

    Raises:
        SetcmasError: The file cannot be read, is damaged, or holds no row.
    """
    try:
        with path.open(encoding='utf-8-sig', newline='') as file:
            rows = list(_parsed_rows(path, csv.reader(file)))
    except OSError as error:
        raise SetcmasError(f"'{path}' cannot be read: {error.strerror}") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise SetcmasError(f"'{path}' is not a CSV file; it must have {_FORM}") from error
    if not rows:
        raise SetcmasError(f"'{path}' holds no rows; it must have {_FORM}")
    return fleet_table(rows)


def _parsed_rows(path: Path, reader: Iterator[list[str]]) -> Iterator[list[float]]:
    header = next(reader, [])
    if tuple(header) != COLUMNS:
        raise SetcmasError(f"'{path}', line 1: '{','.join(header)}' is not {_FORM}")
    for number, cells in enumerate(reader, start=2):
        try:
            row = list(map(float, cells))
            if len(row) != len(COLUMNS) or row[0] - row[0] != 0 or row[1] < 1 or row[1] % 1:
                raise ValueError
        except ValueError:
            raise SetcmasError(
                f"'{path}', line {number}: '{','.join(cells)}' is not a row; it must be seven "
                f'numbers ({",".join(COLUMNS)}) with robot a whole number from 1'
            ) from None
        yield row
