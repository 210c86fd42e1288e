"""Columns of the CSV files of a run, for writing, reading and the docs."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from io import TextIOWrapper
from itertools import chain, islice
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
        must: Requirement, for messages.
        form: Format specification.
        parsed: Returns the values of cells, an array or a list; raises ValueError.
    """

    must: str
    form: str
    parsed: Callable[[Sequence[str]], Any]


def _numbers(cells: Sequence[str]) -> Any:
    return np.array(cells, dtype=float)


def _bounded(cells: Sequence[str], least: float, most: float, whole: bool = True) -> Any:
    values = _numbers(cells)
    if not ((values >= least) & (values <= most)).all() or (whole and (values % 1).any()):
        raise ValueError
    return values


def _receivers(cells: Sequence[str]) -> list[str]:
    _bounded([cell for cell in cells if cell != ALL], 1, MAX_ROBOTS)
    return list(cells)


def _known_numbers(cells: Sequence[str]) -> Any:
    return _numbers([cell or 'nan' for cell in cells])


def _indices(cells: Sequence[str]) -> Any:
    _bounded([cell for cell in cells if cell], 0, _MOST_COUNTED)
    return _known_numbers(cells)


_LATEST_S = 1e6
_MOST_COUNTED = 1e15
_ROBOT = f'a whole number from 1 to {MAX_ROBOTS}'
TIME = Cells(
    f'a number up to {_LATEST_S:g}',
    '.6f',
    partial(_bounded, least=-_LATEST_S, most=_LATEST_S, whole=False),
)
NUMBER = Cells('a number', '.9f', _numbers)
SHORT_NUMBER = Cells('a number', '.9g', _numbers)
COUNT = Cells('a whole number', '.0f', partial(_bounded, least=0, most=_MOST_COUNTED))
ROBOT = Cells(_ROBOT, '.0f', partial(_bounded, least=1, most=MAX_ROBOTS))
RECEIVER = Cells(f"{_ROBOT}, or '{ALL}'", '', _receivers)
SECONDS = Cells('a number, or empty', '', _known_numbers)
EXACT_NUMBER = Cells('a number', '', _numbers)
INDEX = Cells('a whole number, or empty', '', _indices)
TEXT = Cells('text', '', list)


@dataclass(frozen=True)
class Column:
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
    columns: tuple[Column, ...]
    further: tuple[Column, ...] = ()

    @property
    def header(self) -> str:
        """The names of the columns that it always has."""
        return _header(self.columns)

    def write(self, path: Path, rows: Iterable[Sequence[Any]], further: bool = False) -> None:
        """Write rows, whole or not at all; equal rows give equal files.

        Args:
            path: The file.
            rows: The values of each row, in the order of the columns.
            further: Whether the rows have the further columns.

        Raises:
            OSError: The file cannot be written.
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
_ROWS_AT_ONCE = 50_000  # as texts they take ten times the memory
_LONGEST_SHOWN = 200


def _short(text: str) -> str:
    line = ' '.join(text[: 2 * _LONGEST_SHOWN].split())
    return line if len(line) <= _LONGEST_SHOWN else f'{line[:_LONGEST_SHOWN]}…'


def _header(columns: Iterable[Column]) -> str:
    return ','.join(column.name for column in columns)


def _values(path: Path, columns: Sequence[Column], rows: Iterator[list[str]]) -> list[Any]:
    blocks = [list(_parsed(path, columns, [], 2))]
    line = 2
    while block := list(islice(rows, _ROWS_AT_ONCE)):
        blocks.append(list(_parsed(path, columns, block, line)))
        line += len(block)
    return [
        np.concatenate(parts) if isinstance(parts[0], np.ndarray) else list(chain(*parts))
        for parts in zip(*blocks, strict=True)
    ]


def _parsed(
    path: Path, columns: Sequence[Column], rows: list[list[str]], first: int
) -> Iterator[Any]:
    for number, row in enumerate(rows, start=first):
        if len(row) != len(columns):
            raise _damage(path, number, row, columns, f'it must have {len(columns)} cells')
    cells = list(zip(*rows, strict=True)) or [()] * len(columns)
    for column, own in zip(columns, cells, strict=True):
        try:
            yield column.cells.parsed(own)
        except ValueError:
            i = next(i for i, cell in enumerate(own) if not _fits(column, cell))
            must = f'{column.name} must be {column.cells.must}'
            raise _damage(path, first + i, rows[i], columns, must) from None


def _fits(column: Column, cell: str) -> bool:
    try:
        column.cells.parsed([cell])
    except ValueError:
        return False
    return True


def _damage(
    path: Path, line: int, row: Iterable[str], columns: Iterable[Column], must: str
) -> SetcmasError:
    text = _short(','.join(row))
    return SetcmasError(
        f"'{path}', line {line}: '{text}' is not a row of {_header(columns)}; {must}"
    )


def _columns(cells: Cells, /, **meanings: str) -> tuple[Column, ...]:
    """Return columns with the same kind of cells, by their names."""
    return tuple(Column(name, cells, meaning) for name, meaning in meanings.items())


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
        *_columns(COUNT, overruled='1 if safety limited its command, else 0'),
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
