"""Conversion of a bag to a CSV file for each topic, and the tables of its run."""

from __future__ import annotations

import csv
import math
import re
import tempfile
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import lru_cache
from itertools import chain, count
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys.base import normalize_fieldname
from rosbags.typesys.store import Typestore

from setcmas_simu.errors import SetcmasError, file_errors
from setcmas_simu.fleet.planar_pose import yaw_of_quaternion
from setcmas_simu.fleet.topics import TRIG_ODOM
from setcmas_tools.bags.bag_reader import Bag, open_bag
from setcmas_tools.run.run_folder import stem_of_bag
from setcmas_tools.run.run_samples import RunSamples
from setcmas_tools.run.run_tables import FILE_NAMES, FLEET, write_tables


@dataclass(frozen=True)
class ConversionReport:
    """Result of a conversion; as text, the lines to print.

    Attributes:
        folder: Folder of the files.
        files: One CSV file for each topic, sorted by topic.
        fleet: The fleet's table; None if the bag has no odometry of the fleet.
        messages: Number of rows of all topics.
        duration: From the first to the last message, in s.
        notices: A line for each loss in the bag.
    """

    folder: Path
    files: list[Path]
    fleet: Path | None
    messages: int
    duration: float
    notices: list[str]

    def __str__(self) -> str:
        fleet = f' and {self.fleet.name}' if self.fleet else ''
        number = len(self.files)
        plural = 's' if number != 1 else ''
        summary = (
            f'{self.messages:,} messages of {number} topic{plural}, {self.duration:.1f} s: '
            f'{number} CSV file{plural}{fleet} in {self.folder}'
        )
        return '\n'.join([*self.notices, summary])


def convert(bag: Path, output: Path | None = None) -> ConversionReport:
    """Write a CSV file for each topic of a bag, and the tables of the fleet and its communication.

    States on trig_odom, which are repeated until the next one is sent, have one row.
    Existing files of these names are replaced at the end, all at once.

    Args:
        bag: A path that `open_bag` accepts.
        output: Folder of the files; by default `csv` next to a bag folder named `bag`, else
            `<name of the bag>_csv` next to the bag.

    Raises:
        SetcmasError: The bag cannot be read, or the files cannot be written.
    """
    folder = output or _default_output(bag)
    with open_bag(bag) as source, file_errors(f"CSV files cannot be written to '{folder}'"):
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix='.converting-', dir=folder) as unfinished:
            return _write_files(source, Path(unfinished), folder)


def _default_output(bag: Path) -> Path:
    resolved = bag.resolve()
    if resolved.is_dir() and (resolved / 'bag').is_dir():
        resolved /= 'bag'
    found, here = resolved.parent / f'{stem_of_bag(resolved)}csv', Path.cwd()
    return found if bag.is_absolute() or here not in found.parents else found.relative_to(here)


def _write_files(bag: Bag, unfinished: Path, folder: Path) -> ConversionReport:
    names = file_names(topic.name for topic in bag.topics)
    samples = RunSamples(bag.topics)
    rows = {
        topic: TopicTable(
            unfinished / name,
            bag.types,
            skip_repeated=topic.name.endswith(f'/{TRIG_ODOM}'),  # it repeats the last state sent
        )
        for topic, name in zip(bag.topics, names, strict=True)
    }
    takers = {topic: [own.add, *samples.collectors(topic)] for topic, own in rows.items()}
    bag.deliver(takers)
    written = [own for own in rows.values() if own.nb_rows]
    if not written:
        raise SetcmasError(f"bag '{bag.path}' cannot be read: {bag.notices[-1]}")
    for own in written:
        own.finish()
    if tables := samples.tables():
        write_tables(tables, unfinished)
    for path in sorted(unfinished.iterdir()):
        path.replace(folder / path.name)
    return ConversionReport(
        folder,
        [folder / own.path.name for own in written],
        folder / FLEET.name if tables else None,
        sum(own.nb_rows for own in written),
        (bag.end_ns - bag.start_ns) / 1e9,
        bag.notices + samples.notices,
    )


def file_names(topics: Iterable[str]) -> list[str]:
    """Return a file name for each topic, such as tb3_1_odom.csv for /tb3_1/odom.

    Names that would be equal get a number, also those that differ in upper and lower case only.
    """
    taken = set(FILE_NAMES)
    names = []
    for topic in topics:
        stem = re.sub(r'[^A-Za-z0-9_.-]', '_', topic.strip('/')) or 'topic'
        candidates = chain([f'{stem}.csv'], (f'{stem}_{number}.csv' for number in count(2)))
        names.append(next(name for name in candidates if name.lower() not in taken))
        taken.add(names[-1].lower())
    return names


_BUFFERED = 100
_LONGEST_CELL = 2**31 - 1


class TopicTable:
    """A CSV file: first column t (s), then the flattened message; every row has every column.

    Columns that an array gains when it grows come last, and are empty in the rows before.

    Attributes:
        nb_rows: Number of rows so far.
    """

    def __init__(self, path: Path, types: Typestore, skip_repeated: bool = False) -> None:
        """Start a table of messages of some types; the file, which must be new, appears later.

        With `skip_repeated`, a message that is equal to the one before it has no row.
        """
        self.path = path
        self.nb_rows = 0
        self._types = types
        self._skip_repeated = skip_repeated
        self._last: dict[str, Any] = {}
        self._columns: dict[str, None] = {}
        self._nb_first_columns = 0
        # Not written row by row: a bag may have more topics than a process may open files.
        self._rows: list[list[Any]] = []

    def add(self, time_ns: int, message: Any) -> None:
        """Add the row of a message received `time_ns` after t = 0, or raise OSError."""
        cells = cells_of(self._types, message)
        if self._skip_repeated and cells == self._last:
            return
        self._last = cells
        self._columns.update(dict.fromkeys(cells))
        if not self.nb_rows:
            self._nb_first_columns = len(self._columns)
            self._rows.append(['t', *self._columns])
        row = (cells.get(column, '') for column in self._columns)
        self._rows.append([seconds_text(time_ns), *row])
        self.nb_rows += 1
        if len(self._rows) > _BUFFERED:
            self._write()

    def finish(self) -> None:
        """Write the last rows, and fill up rows that lack columns, or raise OSError."""
        self._write()
        if len(self._columns) > self._nb_first_columns:
            self._fill_up_rows()

    def _write(self) -> None:
        with self.path.open('a', encoding='utf-8', newline='') as file:
            csv.writer(file, lineterminator='\n').writerows(self._rows)
        self._rows.clear()

    def _fill_up_rows(self) -> None:
        filled = self.path.with_name(f'{self.path.name}.filled')
        with (
            self.path.open(encoding='utf-8', newline='') as source,
            filled.open('w', encoding='utf-8', newline='') as target,
        ):
            csv.field_size_limit(_LONGEST_CELL)  # a robot description is longer than the default
            rows, writer = csv.reader(source), csv.writer(target, lineterminator='\n')
            next(rows)
            writer.writerow(['t', *self._columns])
            for row in rows:
                writer.writerow(row + [''] * (1 + len(self._columns) - len(row)))
        filled.replace(self.path)


_NANO = 1_000_000_000
STAMPS = ('builtin_interfaces/msg/Time', 'builtin_interfaces/msg/Duration')

LONGEST_ARRAY = 10_000
"""A longer array, such as an image, has one column with its length."""

_PLACEHOLDER = 'structure_needs_at_least_one_member'  # how an empty message is represented
_ORIENTATIONS = (
    'orientation',
    'pose.orientation',
    'pose.pose.orientation',
    'rotation',
    'transform.rotation',
)


def seconds_text(nanoseconds: int) -> str:
    """Return a time or a duration in s with 9 decimals, without rounding."""
    sign = '-' if nanoseconds < 0 else ''
    seconds, rest = divmod(abs(nanoseconds), _NANO)
    return f'{sign}{seconds}.{rest:09d}'


@lru_cache(maxsize=4096)
def _float32(value: float) -> float:
    """Return the number with the shortest text for a single-precision one, such as 0.1."""
    return float(str(np.float32(value)))


def _text(value: str) -> str:
    # Before Python 3.13, `csv` does not quote a carriage return, which then ends the row.
    return value.replace('\r\n', '\n').replace('\r', '\n') if '\r' in value else value


_CELLS: dict[str, Callable[[Any], Any]] = {'bool': int, 'float32': _float32, 'string': _text}
"""Converters of values to cells, by type; `csv` writes other values unchanged."""


def cells_of(types: Typestore, message: Any) -> dict[str, Any]:
    """Return the cells of a message by the names of their columns.

    Fields are joined by dots (`pose.pose.position.x`), arrays are numbered (`name[0]`), times and
    durations are one column in s with 9 decimals, booleans are 0 and 1. An array with more than
    `LONGEST_ARRAY` elements, such as an image, is one column with its length (`data.length`).
    A pose, a transform or an orientation adds a column `yaw` in rad.

    Args:
        types: It has the definitions of the message's type and of its parts.
        message: A message of rosbags.
    """
    cells: dict[str, Any] = {}
    _add_fields(cells, '', types, message)
    for name in _ORIENTATIONS:
        if f'{name}.w' in cells:
            x, y, z, w = (cells[f'{name}.{part}'] for part in 'xyzw')
            # A zero quaternion has no heading.
            cells['yaw'] = yaw_of_quaternion(x, y, z, w) if x or y or z or w else math.nan
            break
    return cells


def _add_fields(cells: dict[str, Any], prefix: str, types: Typestore, message: Any) -> None:
    for field, value_type in types.fielddefs[message.__msgtype__][1]:
        if field != _PLACEHOLDER:
            value = getattr(message, normalize_fieldname(field))
            _add_value(cells, f'{prefix}{field}', types, value_type, value)


def _add_value(
    cells: dict[str, Any], name: str, types: Typestore, value_type: Any, value: Any
) -> None:
    kind, detail = value_type
    if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE):
        if len(value) > LONGEST_ARRAY:
            cells[f'{name}.length'] = len(value)
            return
        elements = value.tolist() if isinstance(value, np.ndarray) else value
        for i, element in enumerate(elements):
            _add_value(cells, f'{name}[{i}]', types, detail[0], element)
    elif kind == Nodetype.BASE:
        convert = _CELLS.get(detail[0])
        cells[name] = convert(value) if convert else value
    elif detail in STAMPS:
        cells[name] = seconds_text(value.sec * _NANO + value.nanosec)
    else:
        _add_fields(cells, f'{name}.', types, value)
