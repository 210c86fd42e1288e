"""Columns of the CSV files of a run, for writing, reading and the docs."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from io import TextIOWrapper
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

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
        least: Least number; an infinite one allows NaN, too.
        most: Largest number.
        is_text: Whether they are texts.
    """

    form: str
    least: float = -math.inf
    most: float = math.inf
    is_text: bool = False


_LATEST_S = 1e6
TIME = Cells('.6f', -_LATEST_S, _LATEST_S)
NUMBER = Cells('.9f')
SHORT_NUMBER = Cells('.9g')
COUNT = Cells('.0f', 0, 1e15)
ROBOT = Cells('.0f', 1, MAX_ROBOTS)
SECONDS = Cells('.6f')
TEXT = Cells('', is_text=True)


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

    def read(self, path: Path) -> list[NDArray[Any]] | None:
        """Return the values of each column, numbers or texts; None if there is no file.

        Raises:
            SetcmasError: The file cannot be read or is damaged.
        """
        try:
            with TextIOWrapper(open_limited(path, _MOST_BYTES), 'utf-8-sig') as file:
                return self._read(file)
        except FileNotFoundError:
            return None
        except OSError as error:
            raise SetcmasError(f"'{path}' cannot be read: {error.strerror}") from error
        except ValueError as error:
            # What follows is advice about numpy's arguments.
            reason = ' '.join(str(error).partition(';')[0][:_LONGEST_REASON].split())
            raise SetcmasError(
                f"'{path}' is damaged ({reason}); it must have the columns {self.header}"
            ) from error

    def _read(self, file: TextIOWrapper) -> list[NDArray[Any]]:
        """Return the columns of an open file, or raise ValueError."""
        header = file.readline().rstrip('\n')
        columns = self.columns
        if header != self.header:
            columns += self.further
            if header != _header(columns):
                raise ValueError(f"its first line is '{header}'")
        with warnings.catch_warnings():
            warnings.simplefilter('ignore', UserWarning)  # a table without rows is one
            rows = np.loadtxt(
                file,
                dtype=[(one.name, object if one.cells.is_text else float) for one in columns],
                delimiter=',',
                quotechar='"',
                comments=None,
                ndmin=1,
            )
        return [_within_limits(column, rows[column.name]) for column in columns]


_MOST_BYTES = 1_000_000_000
_LONGEST_REASON = 300


def _header(columns: Iterable[CsvColumn]) -> str:
    return ','.join(column.name for column in columns)


def _within_limits(column: CsvColumn, values: NDArray[Any]) -> NDArray[Any]:
    """Return values, or raise ValueError if the column allows fewer."""
    least, most = column.cells.least, column.cells.most
    if math.isfinite(least) and not ((least <= values) & (values <= most)).all():
        raise ValueError(f'{column.name} must be from {least:g} to {most:g}')
    return values


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
        *_columns(TEXT, receiver=f'number of the receiving robot; `{ALL}`: broadcasts'),
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
    'values that laws sent to other robots, a row for each',
    (
        *_T_ROBOT,
        *_columns(TEXT, value='the value as JSON: a number, an array or a dictionary of these'),
    ),
)
CSV_FILES = (FLEET, COMMANDS, DRAWINGS, SAFETY, COUNTS, TRIGGERS, GRAPH, MESSAGES)
