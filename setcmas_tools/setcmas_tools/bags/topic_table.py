"""CSV file of one topic: a row for each message, written as the messages are read."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
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


def cells_of(kind: str) -> Callable[[Any], list[Any]]:
    """Return the converter of an array, with elements of a type, to its cells."""
    cell = _CELLS.get(kind)

    def cells(array: Any) -> list[Any]:
        values = array.tolist() if isinstance(array, np.ndarray) else list(array)
        return [cell(value) for value in values] if cell else values

    return cells


LONGEST_ARRAY = 10_000
"""A longer array, such as an image, has one column with its length."""

_TOO_LONG = -1

Column: TypeAlias = tuple[tuple[float, ...], str]
"""Place of a column among all that messages of the type can have, for sorting, and its name."""

Lengths: TypeAlias = tuple[int, ...]
"""Lengths of all arrays of a message, in the order of its fields; they define its columns."""


Field: TypeAlias = tuple[str, str, Callable[[Any], Any] | None]
"""Name of a column, path of its value in a message, and conversion of the value to a cell."""


class Fields:
    """Fields with one value each that follow each other, read at once."""

    def __init__(self, fields: Sequence[Field]) -> None:
        self._names, paths, converts = zip(*fields, strict=True)
        get = attrgetter(*paths)
        self._get = get if len(paths) > 1 else lambda message: (get(message),)
        self._converts = [(i, convert) for i, convert in enumerate(converts) if convert]

    def read(self, message: Any, cells: list[Any], _lengths: list[int], /) -> None:
        """Append the values."""
        values = list(self._get(message))
        for i, convert in self._converts:
            values[i] = convert(values[i])
        cells += values

    def columns(self, _lengths: Iterator[int], /) -> Iterator[Column]:
        """Yield the columns."""
        for i, name in enumerate(self._names):
            yield (i,), name


@dataclass(frozen=True)
class Array:
    """An array of values, or of messages.

    Attributes:
        elements: Returns the array of a message.
        cells: Returns the cells of an array of values; None for an array of messages.
        parts: The fields of each element of an array of messages.
    """

    name: str
    elements: Callable[[Any], Sequence[Any]]
    cells: Callable[[Any], list[Any]] | None
    parts: Sequence[Part] = ()

    def read(self, message: Any, cells: list[Any], lengths: list[int]) -> None:
        """Append the elements, or their number."""
        elements = self.elements(message)
        if len(elements) > LONGEST_ARRAY:
            lengths.append(_TOO_LONG)
            cells.append(len(elements))
            return
        lengths.append(len(elements))
        if self.cells:
            cells += self.cells(elements)
            return
        for element in elements:
            for part in self.parts:
                part.read(element, cells, lengths)

    def columns(self, lengths: Iterator[int]) -> Iterator[Column]:
        """Yield the columns of each element, or that of the length."""
        length = next(lengths)
        if length == _TOO_LONG:
            yield (math.inf,), f'{self.name}.length'
        for i in range(length):
            if self.cells:
                yield (i,), f'{self.name}[{i}]'
            else:
                for place, name in columns(self.parts, lengths):
                    yield (i, *place), f'{self.name}[{i}].{name}'


Part: TypeAlias = Fields | Array


def columns(parts: Sequence[Part], lengths: Iterator[int]) -> Iterator[Column]:
    """Yield the columns of a message with arrays of these lengths."""
    for i, part in enumerate(parts):
        for place, name in part.columns(lengths):
            yield (i, *place), name


_PLACEHOLDER = 'structure_needs_at_least_one_member'  # how an empty message is represented
_QUATERNION = 'geometry_msgs/msg/Quaternion'
_ORIENTATIONS = (
    'orientation',
    'pose.orientation',
    'pose.pose.orientation',
    'rotation',
    'transform.rotation',
)


def parts_of_rows(store: Typestore, msgtype: str) -> list[Part]:
    """Return the parts of the rows of a message type.

    Fields are joined by dots (`pose.pose.position.x`), arrays are numbered (`name[0]`), times and
    durations are one column in s with 9 decimals, booleans are 0 and 1. An array with more than
    `LONGEST_ARRAY` elements, such as an image, is one column with its length (`data.length`). A
    message with a pose, a transform or an orientation has a last column `yaw` in rad.

    Args:
        store: Holds the definitions of the type and its parts.
        msgtype: Name of the type, such as `nav_msgs/msg/Odometry`.
    """
    fields = list(_parts_of(store, msgtype))
    if orientation := _orientation(store, msgtype):
        fields.append(('yaw', orientation, _yaw))
    return _grouped(fields)


def _grouped(found: Iterable[Field | Array]) -> list[Part]:
    """Return the parts of a row: arrays, and the fields between them."""
    parts: list[Part] = []
    waiting: list[Field] = []
    for one in [*found, None]:
        if isinstance(one, tuple):
            waiting.append(one)
            continue
        if waiting:
            parts.append(Fields(waiting))
        waiting = []
        if one:
            parts.append(one)
    return parts


def _parts_of(
    store: Typestore, msgtype: str, name: str = '', path: str = ''
) -> Iterator[Field | Array]:
    for field, (kind, detail) in _fields(store, msgtype):
        field_name, field_path = f'{name}{field}', f'{path}{normalize_fieldname(field)}'
        if kind == Nodetype.NAME and detail not in STAMPS:
            yield from _parts_of(store, detail, f'{field_name}.', f'{field_path}.')
        elif kind in (Nodetype.BASE, Nodetype.NAME):
            yield field_name, field_path, _CELLS.get(_type_name(kind, detail))
        else:
            get = attrgetter(field_path)
            element_kind, element = detail[0]
            if element_kind == Nodetype.NAME and element not in STAMPS:
                yield Array(field_name, get, None, _grouped(_parts_of(store, element)))
            else:
                yield Array(field_name, get, cells_of(_type_name(element_kind, element)))


def _fields(store: Typestore, msgtype: str) -> list[tuple[str, Any]]:
    return [field for field in store.fielddefs[msgtype][1] if field[0] != _PLACEHOLDER]


def _type_name(kind: Nodetype, detail: Any) -> str:
    name: str = detail[0] if kind == Nodetype.BASE else detail
    return name


def _yaw(q: Any) -> float:
    yaw: float = yaw_of_quaternion(q.x, q.y, q.z, q.w)
    return yaw if q.w or q.x or q.y or q.z else math.nan  # a zero quaternion has no heading


def _orientation(store: Typestore, msgtype: str) -> str | None:
    for path in _ORIENTATIONS:
        found: str | None = msgtype
        for name in path.split('.'):
            fields = dict(_fields(store, found)) if found else {}
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

    def __init__(self, path: Path, parts: Sequence[Part]) -> None:
        """Start a table; the file, which must be new, appears with the first rows."""
        self.path = path
        self._parts = parts
        self._lines: list[str] = []
        self._write_row = _row_writer(self._lines.append)
        self.nb_rows = 0
        # Lengths of arrays, each with the number of the first row that has them.
        self._lengths: list[tuple[int, Lengths]] = []

    def add(self, time_ns: int, message: Any) -> None:
        """Add the row of a message received `time_ns` after t = 0.

        Raises:
            OSError: The file cannot be written.
        """
        cells: list[Any] = [seconds_text(time_ns)]
        found: list[int] = []
        for part in self._parts:
            part.read(message, cells, found)
        lengths = tuple(found)
        if not self._lengths:
            self._write_row(['t', *(name for _, name in columns(self._parts, iter(lengths)))])
        if not self._lengths or lengths != self._lengths[-1][1]:
            self._lengths.append((self.nb_rows, lengths))
        self._write_row(cells)
        self.nb_rows += 1
        if len(self._lines) >= _ROWS_IN_MEMORY:
            self._write_lines()

    def finish(self) -> None:
        """Write the last rows, and fill up rows that lack columns.

        Raises:
            OSError: The file cannot be written.
        """
        self._write_lines()
        if len(self._lengths) > 1:
            self._fill_up_rows()

    def _write_lines(self) -> None:
        with self.path.open('a', encoding='utf-8', newline='') as file:
            file.writelines(self._lines)
        self._lines.clear()

    def _fill_up_rows(self) -> None:
        different = {lengths for _, lengths in self._lengths}
        every = sorted({c for lengths in different for c in columns(self._parts, iter(lengths))})
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
                own = list(columns(self._parts, iter(lengths)))
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
