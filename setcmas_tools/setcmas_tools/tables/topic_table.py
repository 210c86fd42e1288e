"""The CSV file of one topic, written while messages come in."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from functools import reduce
from itertools import chain
from pathlib import Path
from typing import Any

from setcmas_tools.tables.cells import seconds_text
from setcmas_tools.tables.columns import Shape, fill_up, union
from setcmas_tools.tables.flattening_code import Flattener

_ROWS_IN_MEMORY = 2_000
_LONGEST_CELL = 2**31 - 1


class CsvTable:
    """A CSV file: first column t (s), then the flattened message; every row has every column.

    Columns of arrays of varying length are known only at the end: rows are filled up then.
    """

    def __init__(self, path: Path, flattener: Flattener) -> None:
        """Start a table; the file appears with the first rows.

        Args:
            path: A file that does not exist.
            flattener: That of the messages' type.
        """
        self._path = path
        self._flattener = flattener
        self._lines: list[str] = []
        self._nb_rows = 0
        # Each shape with the number of the first row that has it.
        self._shapes: list[tuple[int, Shape]] = [(0, ())] if flattener.has_fixed_columns else []

    def add(self, time_ns: int, message: Any) -> None:
        """Add the row of a message that came `time_ns` after the bag's start.

        Raises:
            OSError: The file cannot be written.
        """
        if not self._flattener.has_fixed_columns:
            shape = self._flattener.shape(message)
            if not self._shapes or shape != self._shapes[-1][1]:
                self._shapes.append((self._nb_rows, shape))
        self._lines.append(f'{seconds_text(time_ns)}{self._flattener.cells(message)}\n')
        self._nb_rows += 1
        if len(self._lines) >= _ROWS_IN_MEMORY:
            self._write_rows()

    def finish(self) -> None:
        """Write what is left, and fill up rows that lack columns.

        Raises:
            OSError: The file cannot be written.
        """
        self._write_rows()
        if len(self._shapes) > 1:
            self._fill_up_rows()

    def _write_rows(self) -> None:
        with self._path.open('a', encoding='utf-8', newline='') as file:
            if file.tell() == 0:
                file.write(','.join(['t', *self._flattener.columns(self._shapes[0][1])]) + '\n')
            file.writelines(self._lines)
        self._lines.clear()

    def _fill_up_rows(self) -> None:
        widest = reduce(union, (shape for _, shape in self._shapes))
        filled = self._path.with_name(f'{self._path.name}.filled')
        with (
            self._path.open(encoding='utf-8', newline='') as source,
            filled.open('w', encoding='utf-8', newline='') as target,
        ):
            csv.field_size_limit(_LONGEST_CELL)  # a robot description is longer than the default
            rows = csv.reader(source)
            next(rows)
            writer = csv.writer(target, lineterminator='\n')
            writer.writerow(['t', *self._flattener.columns(widest)])
            for shape, row in zip(self._shape_of_each_row(), rows, strict=True):
                cells = fill_up(self._flattener.items, shape, widest, iter(row[1:]))
                writer.writerow(chain(row[:1], cells))
        filled.replace(self._path)

    def _shape_of_each_row(self) -> Iterator[Shape]:
        ends = [first for first, _ in self._shapes[1:]] + [self._nb_rows]
        for (first, shape), end in zip(self._shapes, ends, strict=True):
            for _ in range(first, end):
                yield shape
