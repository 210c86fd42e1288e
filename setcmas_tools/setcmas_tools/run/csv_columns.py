"""Columns of the CSV files of a run, for writing, reading and the docs."""

from __future__ import annotations

import csv
from array import array
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from io import TextIOWrapper
from math import nan
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import MAX_ROBOTS
from setcmas_simu.limited_file import open_limited, written_whole

ALL = 'all'
"""The receiver of a broadcast."""


@dataclass(frozen=True)
class Cells:
    """Values of a column.

    Attributes:
        form: Format specification.
        parsed: Returns the value of a cell, a number or a text; raises ValueError.
    """

    form: str
    parsed: Callable[[str], Any] = float


def _within(least: float, most: float, cell: str) -> float:
    value = float(cell)
    if not least <= value <= most:
        raise ValueError
    return value


def _whole(least: float, most: float, cell: str) -> float:
    value = _within(least, most, cell)
    if value % 1:
        raise ValueError
    return value


def _or_empty(parsed: Callable[[str], float], cell: str) -> float:
    return parsed(cell) if cell else nan


def _receiver(cell: str) -> str:
    if cell != ALL:
        ROBOT.parsed(cell)
    return cell


_LATEST_S = 1e6
TIME = Cells('.6f', partial(_within, -_LATEST_S, _LATEST_S))
NUMBER = Cells('.9f')
SHORT_NUMBER = Cells('.9g')
COUNT = Cells('.0f', partial(_whole, 0, 1e15))
ROBOT = Cells('.0f', partial(_whole, 1, MAX_ROBOTS))
RECEIVER = Cells('', _receiver)
SECONDS = Cells('', partial(_or_empty, float))
EXACT_NUMBER = Cells('')
INDEX = Cells('', partial(_or_empty, COUNT.parsed))
TEXT = Cells('', str)


@dataclass(frozen=True)
class CsvColumn:
    """A column: its name in the first line, its values, and its meaning and unit for the docs."""

    name: str
    cells: Cells
    meaning: str


@dataclass(frozen=True)
class CsvFile:
    """A CSV file with fixed columns.

    Attributes:
        name: Its name in the folder.
        meaning: Meaning of a row, for the docs.
        columns: The columns that it always has.
        further: Columns that may follow, all or none.
    """

    name: str
    meaning: str
    columns: tuple[CsvColumn, ...]
    further: tuple[CsvColumn, ...] = ()

    @property
    def header(self) -> str:
        """The names of the columns that it always has."""
        return _header(self.columns)

    def write(self, path: Path, rows: Iterable[Sequence[Any]], further: bool = False) -> None:
        """Write rows, whole or not at all, or raise OSError; equal rows give equal files.

        Values are in the order of the columns; `further` tells whether rows have the further ones.
        """
        columns = self.columns + (self.further if further else ())
        line = ','.join(f'{{:{column.cells.form}}}' for column in columns) + '\n'
        with written_whole(path) as file:
            file.write(f'{_header(columns)}\n')
            file.writelines(line.format(*row) for row in rows)

    def read(self, path: Path) -> list[Any] | None:
        """Return the values of each column, arrays or lists of text; None if there is no file.

        Raises:
            SetcmasError: The file cannot be read or is damaged.
        """
        try:
            binary = open_limited(path, _MOST_BYTES)
            with TextIOWrapper(binary, 'utf-8-sig', newline='') as file:
                return self._read(path, file)
        except FileNotFoundError:
            return None
        except OSError as error:
            raise SetcmasError(f"'{path}' cannot be read: {error.strerror}") from error
        except (UnicodeDecodeError, csv.Error) as error:
            raise SetcmasError(
                f"'{path}' is not a CSV file; it must have the columns {self.header}"
            ) from error

    def _read(self, path: Path, file: TextIOWrapper) -> list[Any]:
        rows = csv.reader(iter(partial(file.readline, _LONGEST_LINE), ''))
        header = ','.join(next(rows, []))
        for columns in (self.columns, self.columns + self.further):
            if _header(columns) == header:
                return _values(path, columns, rows)
        raise SetcmasError(
            f"'{path}', line 1: '{_short(header)}' is not the columns {self.header}"
        )


_MOST_BYTES = 1_000_000_000
_LONGEST_LINE = 100_000
_LONGEST_SHOWN = 200


def _short(text: str) -> str:
    line = ' '.join(text[: 2 * _LONGEST_SHOWN].split())
    return line if len(line) <= _LONGEST_SHOWN else f'{line[:_LONGEST_SHOWN]}…'


def _header(columns: Iterable[CsvColumn]) -> str:
    return ','.join(column.name for column in columns)


def _values(path: Path, columns: Sequence[CsvColumn], rows: Iterable[list[str]]) -> list[Any]:
    values: list[Any] = [
        [] if column.cells in (TEXT, RECEIVER) else array('d') for column in columns
    ]
    into = [(column.cells.parsed, own.append) for column, own in zip(columns, values, strict=True)]
    for line, row in enumerate(rows, start=2):
        try:
            for (parsed, append), cell in zip(into, row, strict=True):
                append(parsed(cell))
        except ValueError:
            raise SetcmasError(
                f"'{path}', line {line}: '{_short(','.join(row))}' is not a row of "
                f'{_header(columns)} (t up to {_LATEST_S:g} s, robots from 1 to {MAX_ROBOTS})'
            ) from None
    return [np.array(own) if isinstance(own, array) else own for own in values]


def _columns(cells: Cells, /, **meanings: str) -> tuple[CsvColumn, ...]:
    """Return columns with the same kind of cells, by their names."""
    return tuple(CsvColumn(name, cells, meaning) for name, meaning in meanings.items())


_T = _columns(TIME, t='time in s from the first command of the run')
_T_ROBOT = (*_T, *_columns(ROBOT, robot='number of the robot, from 1'))

FLEET = CsvFile(
    'fleet.csv',
    'motion of the robots, a row for each odometry message',
    (
        *_T_ROBOT,
        *_columns(NUMBER, x='position in m', y='position in m', theta='heading in rad'),
        *_columns(NUMBER, v='forward speed in m/s', omega='turn rate in rad/s'),
    ),
)
COMMANDS = CsvFile(
    'commands.csv',
    'velocities that the laws returned, after saturation, a row for each call',
    (*_T_ROBOT, *_columns(NUMBER, vx='velocity along x in m/s', vy='velocity along y in m/s')),
    (
        *_columns(NUMBER, allowed_vx='velocity that a safety filter allowed, along x in m/s'),
        *_columns(NUMBER, allowed_vy='the same along y in m/s'),
        *_columns(COUNT, verdict='0 unchanged, 1 changed, 2 no solution'),
    ),
)
SAFETY = CsvFile(
    'safety.csv',
    'states of the robots in an experiment, a row for each status message',
    (
        *_T_ROBOT,
        *_columns(TEXT, state='`moving`, `paused` or `stopped`'),
        *_columns(COUNT, overruled='1 if safety limited or paused it, else 0'),
    ),
)
DRAWINGS = CsvFile(
    'drawings.csv',
    'spheres that scripts drew',
    (
        *_T_ROBOT,
        *_columns(TEXT, name='topic of the sphere, such as `wp_ref`'),
        *_columns(TEXT, kind='`marker` (replaces the last of this robot and name) or `trail`'),
        *_columns(SHORT_NUMBER, **dict.fromkeys('xyz', 'position in m'), diameter='diameter in m'),
        *_columns(SHORT_NUMBER, **dict.fromkeys(('red', 'green', 'blue', 'alpha'), '0 to 1')),
    ),
)
COUNTS = CsvFile(
    'communication.csv',
    'messages on each link, and broadcasts of each robot',
    (
        *_columns(ROBOT, sender='number of the robot that sent'),
        *_columns(RECEIVER, receiver=f'number of the receiving robot; `{ALL}`: broadcasts'),
        *_columns(COUNT, sent='messages sent', received='messages that arrived'),
        *_columns(COUNT, lost='messages that were lost'),
        *_columns(SECONDS, mean_interval='mean time between arrivals, or broadcasts, in s'),
    ),
)
TRIGGERS = CsvFile(
    'triggers.csv',
    'evaluations of triggering conditions, a row for each',
    (*_T_ROBOT, *_columns(COUNT, sent='1 if it triggered and the robot sent its state, else 0')),
)
GRAPH = CsvFile(
    'graph.csv',
    'changes of the communication graph, a row for each link',
    (
        *_T,
        *_columns(ROBOT, receiver='number of the robot that receives'),
        *_columns(ROBOT, sender='number of the robot that sends'),
        *_columns(SHORT_NUMBER, weight='weight of the link from t on'),
    ),
)
MESSAGES = CsvFile(
    'messages.csv',
    'values that laws sent to other robots, a row for each number',
    (
        *_T_ROBOT,
        *_columns(TEXT, name='name of the value; empty if it has none'),
        *_columns(INDEX, row='place in an array, from 0; empty for a number'),
        *_columns(INDEX, column='place in a row of a matrix, from 0; else empty'),
        *_columns(EXACT_NUMBER, value='the number'),
    ),
)
CSV_FILES = (FLEET, COMMANDS, DRAWINGS, SAFETY, COUNTS, TRIGGERS, GRAPH, MESSAGES)
