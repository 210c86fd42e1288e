"""CSV file of one topic: a row for each message, written as the messages are read."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice, pairwise
from operator import attrgetter
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys.base import normalize_fieldname
from rosbags.typesys.store import Typestore

from setcmas_simu.fleet.planar_pose import yaw_of_quaternion

_NANO = 1_000_000_000
STAMPS = ('builtin_interfaces/msg/Time', 'builtin_interfaces/msg/Duration')


def seconds_text(nanoseconds: int) -> str:
    """Return a time or a duration in s with 9 decimals, without rounding."""
    sign = '-' if nanoseconds < 0 else ''
    seconds, rest = divmod(abs(nanoseconds), _NANO)
    return f'{sign}{seconds}.{rest:09d}'


def _stamp(stamp: Any) -> str:
    return seconds_text(stamp.sec * _NANO + stamp.nanosec)


@lru_cache(maxsize=4096)
def _float32(value: float) -> float:
    """Return the number with the shortest text for a single-precision one, such as 0.1."""
    return float(str(np.float32(value)))


_CELLS: dict[str, Callable[[Any], Any]] = {
    'bool': int,
    'float32': _float32,
    **dict.fromkeys(STAMPS, _stamp),
}
"""Converters of values to cells, by type; `csv` writes other values unchanged."""


LONGEST_ARRAY = 10_000
"""A longer array, such as an image, has one column with its length."""

_TOO_LONG = -1

Column: TypeAlias = tuple[tuple[float, ...], str]
"""Place of a column among all that messages of the type can have, for sorting, and its name."""

Lengths: TypeAlias = tuple[int, ...]
"""Lengths of all arrays of a message, in the order of its fields; they define its columns."""


@dataclass(frozen=True)
class Array:
    """An array in a message, of values or of messages.

    Attributes:
        cell: Converts a value to a cell; None if it stays as it is.
        row: The fields of each element of an array of messages.
    """

    cell: Callable[[Any], Any] | None = None
    row: Row | None = None

    def read(self, elements: Any, cells: list[Any], lengths: list[int]) -> None:
        """Append the elements, or their number."""
        if len(elements) > LONGEST_ARRAY:
            lengths.append(_TOO_LONG)
            cells.append(len(elements))
            return
        lengths.append(len(elements))
        if self.row:
            for element in elements:
                self.row.read(element, cells, lengths)
            return
        values = elements.tolist() if isinstance(elements, np.ndarray) else elements
        cells += map(self.cell, values) if self.cell else values

    def columns(self, name: str, lengths: Iterator[int]) -> Iterator[Column]:
        """Yield the columns of each element, or that of the length."""
        length = next(lengths)
        if length == _TOO_LONG:
            yield (math.inf,), f'{name}.length'
        for i in range(length):
            if self.row:
                for place, field in self.row.columns(lengths):
                    yield (i, *place), f'{name}[{i}].{field}'
            else:
                yield (i,), f'{name}[{i}]'


Field: TypeAlias = tuple[str, str, Callable[[Any], Any] | Array | None]
"""Name of a column or an array, path of its value in a message, and how it becomes cells."""


class Row:
    """The cells of messages of a type.

    Fields are joined by dots (`pose.pose.position.x`), arrays are numbered (`name[0]`), times and
    durations are one column in s with 9 decimals, booleans are 0 and 1. An array with more than
    `LONGEST_ARRAY` elements, such as an image, is one column with its length (`data.length`).
    """

    def __init__(self, fields: Iterable[Field]) -> None:
        self._fields = list(fields)
        paths = [path for _, path, _ in self._fields]
        get = attrgetter(*paths) if paths else lambda _: ()
        self._get = get if len(paths) != 1 else lambda message: (get(message),)
        self._special = [(i, form) for i, (_, _, form) in enumerate(self._fields) if form]

    def read(self, message: Any, cells: list[Any], lengths: list[int]) -> None:
        """Append the values, and the lengths of arrays."""
        values = list(self._get(message))
        begin = 0
        for i, form in self._special:
            if isinstance(form, Array):
                cells += values[begin:i]
                form.read(values[i], cells, lengths)
                begin = i + 1
            else:
                values[i] = form(values[i])
        cells += values[begin:]

    def columns(self, lengths: Iterator[int]) -> Iterator[Column]:
        """Yield the columns of a message with arrays of these lengths."""
        for i, (name, _, form) in enumerate(self._fields):
            if isinstance(form, Array):
                for place, column in form.columns(name, lengths):
                    yield (i, *place), column
            else:
                yield (i,), name


_PLACEHOLDER = 'structure_needs_at_least_one_member'  # how an empty message is represented
_QUATERNION = 'geometry_msgs/msg/Quaternion'
_ORIENTATIONS = (
    'orientation',
    'pose.orientation',
    'pose.pose.orientation',
    'rotation',
    'transform.rotation',
)


def row_of(store: Typestore, msgtype: str) -> Row:
    """Return the row of a message type such as `nav_msgs/msg/Odometry`.

    Of a message with a pose, a transform or an orientation it ends with a column `yaw` in rad.
    The store holds the definitions of the type and its parts.
    """
    fields = list(_fields_of(store, msgtype))
    if orientation := _orientation(store, msgtype):
        fields.append(('yaw', orientation, _yaw))
    return Row(fields)


def _fields_of(store: Typestore, msgtype: str, name: str = '', path: str = '') -> Iterator[Field]:
    for field, (kind, detail) in _definition(store, msgtype):
        own_name, own_path = f'{name}{field}', f'{path}{normalize_fieldname(field)}'
        if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE):
            element_kind, element = detail[0]
            if element_kind == Nodetype.NAME and element not in STAMPS:
                yield own_name, own_path, Array(row=Row(_fields_of(store, element)))
            else:
                yield own_name, own_path, Array(_cell(element_kind, element))
        elif kind == Nodetype.NAME and detail not in STAMPS:
            yield from _fields_of(store, detail, f'{own_name}.', f'{own_path}.')
        else:
            yield own_name, own_path, _cell(kind, detail)


def _definition(store: Typestore, msgtype: str) -> list[tuple[str, Any]]:
    return [field for field in store.fielddefs[msgtype][1] if field[0] != _PLACEHOLDER]


def _cell(kind: Nodetype, detail: Any) -> Callable[[Any], Any] | None:
    return _CELLS.get(detail[0] if kind == Nodetype.BASE else detail)


def _yaw(q: Any) -> float:
    yaw: float = yaw_of_quaternion(q.x, q.y, q.z, q.w)
    return yaw if q.w or q.x or q.y or q.z else math.nan  # a zero quaternion has no heading


def _orientation(store: Typestore, msgtype: str) -> str | None:
    for path in _ORIENTATIONS:
        found: str | None = msgtype
        for name in path.split('.'):
            fields = dict(_definition(store, found)) if found else {}
            kind, detail = fields.get(name, (None, None))
            found = detail if kind == Nodetype.NAME else None
        if found == _QUATERNION:
            return path
    return None


_ROWS_IN_MEMORY = 2_000
_LONGEST_CELL = 2**31 - 1


class TopicTable:
    """A CSV file: first column t (s), then the flattened message; every row has every column.

    Columns of arrays of varying length are known only at the end: rows are filled up then.

    Attributes:
        nb_rows: Number of rows so far.
    """

    def __init__(self, path: Path, row: Row, skip_repeated: bool = False) -> None:
        """Start a table; the file, which must be new, appears with the first rows.

        With `skip_repeated`, a message that is equal to the one before it has no row.
        """
        self.path = path
        self._row = row
        self._skip_repeated = skip_repeated
        self._last: list[Any] = []
        self._lines: list[str] = []
        self._write_row = _row_writer(self._lines.append)
        self.nb_rows = 0
        # Lengths of arrays, each with the number of the first row that has them.
        self._lengths: list[tuple[int, Lengths]] = []

    def add(self, time_ns: int, message: Any) -> None:
        """Add the row of a message received `time_ns` after t = 0, or raise OSError."""
        cells: list[Any] = [seconds_text(time_ns)]
        found: list[int] = []
        self._row.read(message, cells, found)
        if self._skip_repeated:
            if cells[1:] == self._last:
                return
            self._last = cells[1:]
        lengths = tuple(found)
        if not self._lengths:
            self._write_row(['t', *(name for _, name in self._row.columns(iter(lengths)))])
        if not self._lengths or lengths != self._lengths[-1][1]:
            self._lengths.append((self.nb_rows, lengths))
        self._write_row(cells)
        self.nb_rows += 1
        if len(self._lines) >= _ROWS_IN_MEMORY:
            self._write_lines()

    def finish(self) -> None:
        """Write the last rows, and fill up rows that lack columns, or raise OSError."""
        self._write_lines()
        if len(self._lengths) > 1:
            self._fill_up_rows()

    def _write_lines(self) -> None:
        with self.path.open('a', encoding='utf-8', newline='') as file:
            file.writelines(self._lines)
        self._lines.clear()

    def _fill_up_rows(self) -> None:
        different = {lengths for _, lengths in self._lengths}
        every = sorted({c for lengths in different for c in self._row.columns(iter(lengths))})
        filled = self.path.with_name(f'{self.path.name}.filled')
        with (
            self.path.open(encoding='utf-8', newline='') as source,
            filled.open('w', encoding='utf-8', newline='') as target,
        ):
            csv.field_size_limit(_LONGEST_CELL)  # a robot description is longer than the default
            rows = csv.reader(source)
            next(rows)
            write_row = _row_writer(target.write)
            write_row(['t', *(name for _, name in every)])
            for (first, lengths), (end, _) in pairwise([*self._lengths, (self.nb_rows, ())]):
                own = list(self._row.columns(iter(lengths)))
                for t, *cells in islice(rows, end - first):
                    of_column = dict(zip(own, cells, strict=True))
                    write_row([t, *(of_column.get(column, '') for column in every)])
        filled.replace(self.path)


def _row_writer(write: Callable[[str], object]) -> Callable[[list[Any]], object]:
    return csv.writer(_Lines(write), lineterminator='\r\n').writerow


class _Lines:
    """Lines that end with a line feed.

    Before Python 3.13, `csv` quotes a text with a carriage return only if lines end with one.
    """

    def __init__(self, write: Callable[[str], object]) -> None:
        self._write = write

    def write(self, line: str) -> None:
        self._write(f'{line[:-2]}\n')
