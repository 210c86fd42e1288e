"""Tables of a run, and the CSV files that hold them: their columns, for the docs as well."""

from __future__ import annotations

import json
import math
import warnings
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from io import TextIOWrapper
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from setcmas_ctrl.communication.message_content import checked_value, plain
from setcmas_ctrl.laws.drawing import Sphere
from setcmas_ctrl.laws.references import References
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import MAX_ROBOTS
from setcmas_simu.limited_file import open_limited, read_limited, written_whole
from setcmas_tools.run.fleet_motion import FleetTable, check_extent, fleet_table
from setcmas_tools.run.run_records import (
    Commands,
    CommunicationRecord,
    Counts,
    Drawing,
    SafetyRecord,
    SentMessage,
    commands,
)

ALL = 'all'
"""The receiver of a broadcast."""

_TIME = ('.6f', -1e6, 1e6)
_NUMBER = ('.9f',)
_SHORT_NUMBER = ('.9g',)
_COUNT = ('.0f', 0, 1e15)
_ROBOT = ('.0f', 1, MAX_ROBOTS)
_TEXT = ('',)


@dataclass(frozen=True)
class CsvColumn:
    """A column of a CSV file.

    Attributes:
        name: Its name in the first line.
        meaning: Meaning and unit, for the docs.
        form: Format specification of its values; '' for texts.
        least: Least number; an infinite one allows NaN, too.
        most: Largest number.
    """

    name: str
    meaning: str
    form: str
    least: float = -math.inf
    most: float = math.inf

    def check(self, values: NDArray[Any]) -> None:
        """Raise ValueError for a number that the column does not allow."""
        if math.isfinite(self.least):
            wrong = values[~((self.least <= values) & (values <= self.most))]
            if len(wrong):
                expected = f'it must be from {self.least:g} to {self.most:g}'
                raise ValueError(f'{self.name} is {wrong[0]:g}; {expected}')


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

    def write(self, folder: Path, *columns: ArrayLike) -> None:
        """Write columns, in the file's order, with or without the further ones.

        The file is written whole or not at all; equal columns give equal files.

        Raises:
            OSError: It cannot be written.
        """
        known = (*self.columns, *self.further)[: len(columns)]
        line = ','.join(f'{{:{column.form}}}' for column in known) + '\n'
        rows = zip(*(np.asarray(column).tolist() for column in columns), strict=True)
        with written_whole(folder / self.name) as file:
            file.write(f'{_header(known)}\n')
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
            reason = ' '.join(str(error)[:_LONGEST_REASON].split())
            expected = f'it must have the columns {self.header}'
            raise SetcmasError(f"'{path}' is damaged ({reason}); {expected}") from error

    def rows(self, path: Path) -> list[Any]:
        """Return the rows as tuples, none if there is no file; errors as `read`."""
        columns = self.read(path) or ()
        return list(zip(*(column.tolist() for column in columns), strict=True))

    def _read(self, file: TextIOWrapper) -> list[NDArray[Any]]:
        """Return the columns of an open file, or raise ValueError."""
        header = file.readline().rstrip('\n')
        columns = self.columns if header == self.header else (*self.columns, *self.further)
        if header != _header(columns):
            raise ValueError(f"its first line is '{header}'")
        number = 1

        def lines() -> Iterator[str]:
            nonlocal number
            for number, line in enumerate(file, start=2):  # noqa: B007
                yield line

        try:
            with warnings.catch_warnings():
                warnings.simplefilter('ignore', UserWarning)  # a table without rows is one
                rows = np.loadtxt(
                    lines(),
                    dtype=[(one.name, float if one.form else object) for one in columns],
                    delimiter=',',
                    quotechar='"',
                    comments=None,
                    ndmin=1,
                )
        except ValueError as error:
            # What follows is numpy's own count of rows, which leaves out empty lines.
            raise ValueError(f'line {number}: {str(error).partition(" at row ")[0]}') from error
        for column in columns:
            column.check(rows[column.name])
        return [rows[column.name] for column in columns]


_MOST_BYTES = 1_000_000_000
_LONGEST_REASON = 300


def _header(columns: Iterable[CsvColumn]) -> str:
    return ','.join(column.name for column in columns)


def _columns(values: tuple[Any, ...], /, **meanings: str) -> tuple[CsvColumn, ...]:
    """Return columns with the same kind of values, by their names."""
    return tuple(CsvColumn(name, meaning, *values) for name, meaning in meanings.items())


_T = _columns(_TIME, t='time in s from the first command of the run')
_T_ROBOT = (*_T, *_columns(_ROBOT, robot='number of the robot, from 1'))

FLEET = CsvFile(
    'fleet.csv',
    'motion of the robots, a row for each odometry message',
    (
        *_T_ROBOT,
        *_columns(_NUMBER, x='position in m', y='position in m', theta='heading in rad'),
        *_columns(_NUMBER, v='forward speed in m/s', omega='turn rate in rad/s'),
    ),
)
COMMANDS = CsvFile(
    'commands.csv',
    'velocities that the laws returned, after saturation, a row for each call',
    (*_T_ROBOT, *_columns(_NUMBER, vx='velocity along x in m/s', vy='velocity along y in m/s')),
    (
        *_columns(_NUMBER, allowed_vx='velocity that a safety filter allowed, along x in m/s'),
        *_columns(_NUMBER, allowed_vy='the same along y in m/s'),
        *_columns(_COUNT, verdict='0 unchanged, 1 changed, 2 no solution'),
    ),
)
SAFETY = CsvFile(
    'safety.csv',
    'states of the robots in an experiment, a row for each status message',
    (
        *_T_ROBOT,
        *_columns(_TEXT, state='`moving`, `paused` or `stopped`'),
        *_columns(_COUNT, overruled='1 if safety limited or paused it, else 0'),
    ),
)
DRAWINGS = CsvFile(
    'drawings.csv',
    'spheres that scripts drew',
    (
        *_T_ROBOT,
        *_columns(_TEXT, name='topic of the sphere, such as `wp_ref`'),
        *_columns(_TEXT, kind='`marker` (replaces the last of this robot and name) or `trail`'),
        *_columns(_SHORT_NUMBER, **dict.fromkeys('xyz', 'position in m')),
        *_columns(_SHORT_NUMBER, diameter='diameter in m'),
        *_columns(_SHORT_NUMBER, **dict.fromkeys(('red', 'green', 'blue', 'alpha'), '0 to 1')),
    ),
)
COUNTS = CsvFile(
    'communication.csv',
    'messages on each link, and broadcasts of each robot',
    (
        *_columns(_ROBOT, sender='number of the robot that sent'),
        *_columns(_TEXT, receiver=f'number of the receiving robot; `{ALL}`: broadcasts'),
        *_columns(_COUNT, sent='messages sent', received='messages that arrived'),
        *_columns(_COUNT, lost='messages that were lost'),
        *_columns(('.6f',), mean_interval='mean time between arrivals, or broadcasts, in s'),
    ),
)
TRIGGERS = CsvFile(
    'triggers.csv',
    'evaluations of triggering conditions, a row for each',
    (*_T_ROBOT, *_columns(_COUNT, sent='1 if it triggered and the robot sent its state, else 0')),
)
GRAPH = CsvFile(
    'graph.csv',
    'changes of the communication graph, a row for each link',
    (
        *_T,
        *_columns(_ROBOT, receiver='number of the robot that receives'),
        *_columns(_ROBOT, sender='number of the robot that sends'),
        *_columns(_SHORT_NUMBER, weight='weight of the link from t on'),
    ),
)
MESSAGES = CsvFile(
    'messages.csv',
    'values that laws sent to other robots, a row for each',
    (
        *_T_ROBOT,
        *_columns(_TEXT, value='the value as JSON: a number, an array or a dictionary of these'),
    ),
)
CSV_FILES = (FLEET, COMMANDS, DRAWINGS, SAFETY, COUNTS, TRIGGERS, GRAPH, MESSAGES)

TASK_FILE = 'task.json'
_MOST_TASK_BYTES = 10_000_000
FILE_NAMES = (*(file.name for file in CSV_FILES), TASK_FILE)


@dataclass(frozen=True, eq=False)
class RunTables:
    """What happened in a run.

    Attributes:
        table: The motion of the robots: a row for each state of each robot, as in fleet.csv.
        commands: Velocities that the laws returned, after saturation, if known.
        record: Messages of each link; None if unknown, or if all robots knew all poses.
        drawings: The drawings of the scripts, sorted by time.
        references: The task of the law and its references, if it has one.
        safety: The states of the robots of an experiment; None of a simulation.
        messages: The values that the laws sent with `network.send`, sorted by time, then robot.
    """

    table: FleetTable
    commands: Commands | None = None
    record: CommunicationRecord | None = None
    drawings: list[Drawing] = field(default_factory=list)
    references: References | None = None
    safety: SafetyRecord | None = None
    messages: list[SentMessage] = field(default_factory=list)


def write_tables(tables: RunTables, folder: Path) -> None:
    """Write a file for each table of a run; equal tables give equal files.

    Raises:
        OSError: A file cannot be written.
    """
    FLEET.write(folder, *vars(tables.table).values())
    if tables.commands:
        COMMANDS.write(folder, *vars(tables.commands).values())
    if tables.record:
        write_communication(tables.record, folder)
    if tables.drawings:
        DRAWINGS.write(folder, *zip(*map(_drawing_row, tables.drawings), strict=True))
    if tables.safety:
        SAFETY.write(folder, *vars(tables.safety).values())
    if tables.messages:
        MESSAGES.write(folder, *zip(*map(_message_row, tables.messages), strict=True))
    if tables.references:
        with written_whole(folder / TASK_FILE) as file:
            file.write(f'{tables.references.encoded()}\n')


def read_tables(fleet_csv: Path) -> RunTables:
    """Read a fleet.csv and the other tables in its folder, or raise SetcmasError."""
    folder = fleet_csv.parent
    given = COMMANDS.read(folder / COMMANDS.name)
    safety = SAFETY.read(folder / SAFETY.name)
    return RunTables(
        read_fleet(fleet_csv),
        None if given is None else commands(*given),
        read_communication(folder),
        [_drawing(*row) for row in DRAWINGS.rows(folder / DRAWINGS.name)],
        _read_references(folder / TASK_FILE),
        None if safety is None else SafetyRecord.in_order(*safety),
        _read_messages(folder / MESSAGES.name),
    )


def read_fleet(path: Path) -> FleetTable:
    """Read the motion of a fleet, or raise SetcmasError."""
    columns = FLEET.read(path)
    if columns is None or not len(columns[0]):
        reason = 'cannot be read: there is no such file' if columns is None else 'holds no rows'
        raise SetcmasError(f"'{path}' {reason}; it must have the columns {FLEET.header}")
    table = fleet_table(np.column_stack(columns))
    check_extent(table, path)
    return table


def _drawing_row(drawing: Drawing) -> tuple[Any, ...]:
    *place, colour, alpha = drawing.sphere
    return (*drawing[:4], *place, *colour, alpha)


def _drawing(t: float, robot: float, name: str, kind: str, *numbers: float) -> Drawing:
    x, y, z, diameter, *colour, alpha = numbers
    return Drawing(t, int(robot), name, kind, Sphere(x, y, z, diameter, tuple(colour), alpha))


def _message_row(message: SentMessage) -> tuple[Any, ...]:
    text = json.dumps(plain(message.value)).replace('"', '""')
    return message.t, message.robot, f'"{text}"'


def _read_messages(path: Path) -> list[SentMessage]:
    """Read the messages of a run, or raise SetcmasError."""
    messages = []
    for t, robot, text in MESSAGES.rows(path):
        try:
            messages.append(SentMessage(t, int(robot), checked_value(json.loads(text))))
        except (TypeError, ValueError, RecursionError) as error:
            raise SetcmasError(f"'{path}' is damaged at t = {t:g} s: {error}") from error
    return messages


def write_communication(record: CommunicationRecord, folder: Path) -> None:
    """Write the files of a record; an OSError is raised if this fails."""
    rows: list[tuple[Any, ...]] = [(robot, ALL, *own) for robot, own in record.robots.items()]
    rows += [(sender, receiver, *own) for (receiver, sender), own in record.links.items()]
    COUNTS.write(folder, *zip(*rows, strict=True))
    if record.is_event_triggered:
        TRIGGERS.write(folder, *record.triggers.T)
    GRAPH.write(folder, *record.changes.T)


def read_communication(folder: Path) -> CommunicationRecord | None:
    """Read the record of a run from the folder of its CSV files; None if it has none.

    Raises:
        SetcmasError: A file cannot be read or is damaged.
    """
    rows = COUNTS.rows(folder / COUNTS.name)
    robots: dict[int, Counts] = {}
    links: dict[tuple[int, int], Counts] = {}
    for sender, receiver, sent, received, lost, mean_interval in rows:
        counts = Counts(int(sent), int(received), int(lost), mean_interval)
        if receiver == ALL:
            robots[int(sender)] = counts
        elif receiver.isdecimal():
            links[int(receiver), int(sender)] = counts
        else:
            reason = f"'{receiver[:40]}' is not a robot"
            raise SetcmasError(f"'{folder / COUNTS.name}' is damaged: {reason}")
    triggers, changes = (
        np.reshape(file.rows(folder / file.name), (-1, len(file.columns)))
        for file in (TRIGGERS, GRAPH)
    )
    return CommunicationRecord(robots, links, triggers, changes) if rows else None


def _read_references(path: Path) -> References | None:
    try:
        return References.decoded(read_limited(path, _MOST_TASK_BYTES).decode())
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        expected = 'it must hold a task and its references'
        raise SetcmasError(f"'{path}' is damaged; {expected}: {error}") from error
