"""CSV file of one topic: a row for each message, written as the messages are read."""

from __future__ import annotations

import csv
import math
import sys
from collections.abc import Callable, Iterable
from functools import lru_cache
from io import StringIO
from itertools import islice, pairwise
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys.base import normalize_fieldname
from rosbags.typesys.store import Typestore

from setcmas_simu.fleet.planar_pose import yaw_of_quaternion

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
    A pose, a transform or an orientation adds a last column `yaw` in rad.

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
    for field, (kind, detail) in types.fielddefs[message.__msgtype__][1]:
        name, value = f'{prefix}{field}', getattr(message, normalize_fieldname(field))
        if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE):
            _add_elements(cells, name, types, detail[0], value)
        elif field != _PLACEHOLDER:
            _add_value(cells, name, types, (kind, detail), value)


def _add_elements(
    cells: dict[str, Any], name: str, types: Typestore, element_type: Any, elements: Any
) -> None:
    if len(elements) > LONGEST_ARRAY:
        cells[f'{name}.length'] = len(elements)
        return
    values = elements.tolist() if isinstance(elements, np.ndarray) else elements
    for i, value in enumerate(values):
        _add_value(cells, f'{name}[{i}]', types, element_type, value)


def _add_value(
    cells: dict[str, Any], name: str, types: Typestore, value_type: Any, value: Any
) -> None:
    kind, detail = value_type
    if kind == Nodetype.BASE:
        convert = _CELLS.get(detail[0])
        cells[name] = convert(value) if convert else value
    elif detail in STAMPS:
        cells[name] = seconds_text(value.sec * _NANO + value.nanosec)
    else:
        _add_fields(cells, f'{name}.', types, value)


_BUFFERED = 1_000_000
_LONGEST_CELL = 2**31 - 1


class TopicTable:
    """A CSV file: first column t (s), then the flattened message; every row has every column.

    Columns of arrays of varying length are known only at the end: rows are filled up then.

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
        # Not written row by row: a bag may have more topics than a process may open files.
        self._buffer = StringIO(newline='')
        self._rows = csv.writer(self._buffer, lineterminator='\n')
        # The columns of the rows, each with the number of the first row that has them.
        self._columns: list[tuple[int, list[str]]] = []

    def add(self, time_ns: int, message: Any) -> None:
        """Add the row of a message received `time_ns` after t = 0, or raise OSError."""
        cells = cells_of(self._types, message)
        if self._skip_repeated and cells == self._last:
            return
        if not self._columns or cells.keys() != self._last.keys():
            # Interned: an array that grows has its columns in many rows.
            columns = ['t', *map(sys.intern, cells)]
            if not self._columns:
                self._rows.writerow(columns)
            self._columns.append((self.nb_rows, columns))
        self._last = cells
        self._rows.writerow([seconds_text(time_ns), *cells.values()])
        self.nb_rows += 1
        if self._buffer.tell() > _BUFFERED:
            self._write()

    def finish(self) -> None:
        """Write the last rows, and fill up rows that lack columns, or raise OSError."""
        self._write()
        if len(self._columns) > 1:
            self._fill_up_rows()

    def _write(self) -> None:
        with self.path.open('a', encoding='utf-8', newline='') as file:
            file.write(self._buffer.getvalue())
        self._buffer.seek(0)
        self._buffer.truncate()

    def _fill_up_rows(self) -> None:
        filled = self.path.with_name(f'{self.path.name}.filled')
        with (
            self.path.open(encoding='utf-8', newline='') as source,
            filled.open('w', encoding='utf-8', newline='') as target,
        ):
            csv.field_size_limit(_LONGEST_CELL)  # a robot description is longer than the default
            rows = csv.reader(source)
            next(rows)
            every = _merged(columns for _, columns in self._columns)
            writer = csv.DictWriter(target, every, restval='', lineterminator='\n')
            writer.writeheader()
            for (first, columns), (end, _) in pairwise([*self._columns, (self.nb_rows, [])]):
                for row in islice(rows, end - first):
                    writer.writerow(dict(zip(columns, row, strict=True)))
        filled.replace(self.path)


def _merged(rows: Iterable[list[str]]) -> list[str]:
    """Return the columns of all rows, each behind the one that precedes it in its own row."""
    merged = ['t']
    known = set(merged)
    for columns in rows:
        for before, column in pairwise(columns):
            if column not in known:
                known.add(column)
                merged.insert(merged.index(before) + 1, column)
    return merged
