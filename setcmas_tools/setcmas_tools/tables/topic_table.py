"""CSV file of one topic, written while messages come in."""

from __future__ import annotations

import csv
from collections.abc import Callable
from itertools import islice, pairwise
from pathlib import Path
from typing import Any

from setcmas_tools.tables.cells import seconds_text
from setcmas_tools.tables.columns import Lengths
from setcmas_tools.tables.flatten import Flattener

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
        self._write_row = _row_writer(self._lines.append)
        self._nb_rows = 0
        # Lengths of arrays, each with the number of the first row that has them.
        self._lengths: list[tuple[int, Lengths]] = []

    def add(self, time_ns: int, message: Any) -> None:
        """Add the row of a message that came `time_ns` after the bag's start.

        Raises:
            OSError: The file cannot be written.
        """
        cells, lengths = self._flattener.row(message)
        if not self._lengths:
            columns = self._flattener.columns(lengths)
            self._write_row(['t', *(name for _, name in columns)])
        if not self._lengths or lengths != self._lengths[-1][1]:
            self._lengths.append((self._nb_rows, lengths))
        self._write_row([seconds_text(time_ns), *cells])
        self._nb_rows += 1
        if len(self._lines) >= _ROWS_IN_MEMORY:
            self._write_lines()

    def finish(self) -> None:
        """Write what is left, and fill up rows that lack columns.

        Raises:
            OSError: The file cannot be written.
        """
        self._write_lines()
        if len(self._lengths) > 1:
            self._fill_up_rows()

    def _write_lines(self) -> None:
        with self._path.open('a', encoding='utf-8', newline='') as file:
            file.writelines(self._lines)
        self._lines.clear()

    def _fill_up_rows(self) -> None:
        different = {lengths for _, lengths in self._lengths}
        columns = sorted({c for lengths in different for c in self._flattener.columns(lengths)})
        filled = self._path.with_name(f'{self._path.name}.filled')
        with (
            self._path.open(encoding='utf-8', newline='') as source,
            filled.open('w', encoding='utf-8', newline='') as target,
        ):
            csv.field_size_limit(_LONGEST_CELL)  # a robot description is longer than the default
            rows = csv.reader(source)
            next(rows)
            write_row = _row_writer(target.write)
            write_row(['t', *(name for _, name in columns)])
            for (first, lengths), (end, _) in pairwise([*self._lengths, (self._nb_rows, ())]):
                own = self._flattener.columns(lengths)
                for t, *cells in islice(rows, end - first):
                    of_column = dict(zip(own, cells, strict=True))
                    write_row([t, *(of_column.get(column, '') for column in columns)])
        filled.replace(self._path)


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
