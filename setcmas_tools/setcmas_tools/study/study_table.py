"""Table of a study: rows as they finish, stored in a file, and runs.csv ordered by run."""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

import msgspec

from setcmas_simu.errors import SetcmasError
from setcmas_simu.limited_file import written_whole
from setcmas_tools.study.study_cases import CaseTable
from setcmas_tools.study.study_columns import COLUMNS
from setcmas_tools.study.study_row import Row

FILE_NAME = 'runs.csv'
ROWS = 'runs.jsonl'
"""Rows in the order in which they finished, a line of JSON each: a study continues after them."""

OUTCOME = ('state', 'robots', 'message')
"""Columns with the outcome of a run."""


class StudyTable:
    """Rows of a study so far; use as a context manager.

    Attributes:
        done: Numbers of the runs with a row.
    """

    def __init__(self, folder: Path) -> None:
        """Open the file in a folder, and read its rows.

        Raises:
            OSError: The file cannot be read or written.
            SetcmasError: Another process is writing it, or it is damaged.
        """
        self._file: IO[bytes] = (folder / ROWS).open('a+b')
        _lock(self._file, folder)
        self._folder = folder
        self._places: dict[int, int] = {}
        end = 0
        for place, line in self._lines():
            if line.endswith(b'\n'):  # the last line is incomplete if the study was killed
                self._places[_row(line, self._file, folder).run] = place
                end = place + len(line)
        self._file.truncate(end)
        self._file.seek(end)

    @property
    def done(self) -> set[int]:
        """Numbers of the runs with a row."""
        return set(self._places)

    def __enter__(self) -> StudyTable:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self._file.close()

    def add(self, row: Row) -> None:
        """Write a row.

        Raises:
            OSError: It cannot be written.
        """
        self._places[row.run] = self._file.tell()
        self._file.write(msgspec.json.encode(row) + b'\n')
        self._file.flush()

    def finish(self, cases: CaseTable) -> None:
        """Write runs.csv.

        Raises:
            OSError: A file cannot be written.
        """
        columns = _in_order({name for row in self._rows() for name in row.numbers})
        with written_whole(self._folder / FILE_NAME) as file:
            lines = csv.writer(file, lineterminator='\n')
            lines.writerow(['run', *cases.names, 'seed', *OUTCOME, *columns])
            for row in self._rows():
                own = cases.values(row.run)
                state = [row.state.value, row.robots, row.message]
                numbers = [row.numbers.get(name) for name in columns]
                lines.writerow([row.run, *map(_text, own.values()), *state, *map(_text, numbers)])
            file.flush()
            os.fsync(file.fileno())

    def _rows(self) -> Iterator[Row]:
        """Yield the rows ordered by run, one by one from the file."""
        for run in sorted(self._places):
            self._file.seek(self._places[run])
            yield msgspec.json.decode(self._file.readline(), type=Row)

    def _lines(self) -> Iterator[tuple[int, bytes]]:
        self._file.seek(0)
        place = 0
        for line in self._file:
            yield place, line
            place += len(line)


def _row(line: bytes, file: IO[bytes], folder: Path) -> Row:
    try:
        return msgspec.json.decode(line, type=Row)
    except msgspec.DecodeError as error:
        file.close()
        raise SetcmasError(
            f"'{folder / ROWS}' is damaged ({error}); delete the line "
            f"'{line[:40].decode(errors='replace').rstrip()}', and its run is made again"
        ) from error


def _lock(file: IO[bytes], folder: Path) -> None:
    """Lock a file for this process while it is open, where possible (not on Windows)."""
    with suppress(ImportError):
        import fcntl

        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            file.close()
            raise SetcmasError(
                f"another process is making study '{folder}'; wait for it, or end it"
            ) from error


def read_table(path: Path) -> dict[str, list[Any]]:
    """Read the columns of a runs.csv: numbers if all cells are numbers or empty (None).

    Raises:
        SetcmasError: The file is missing or damaged.
    """
    try:
        with path.open(encoding='utf-8', newline='') as file:
            heads, *rows = csv.reader(file)
            columns = zip(*rows, strict=True) if rows else ([] for _ in heads)
            return {name: _parsed(name, cells) for name, cells in zip(heads, columns, strict=True)}
    except (OSError, UnicodeDecodeError, csv.Error, ValueError) as error:
        raise SetcmasError(f"'{path}' cannot be read; it must be the table of a study") from error


def _parsed(name: str, cells: Any) -> list[Any]:
    if name in OUTCOME:
        return list(cells)
    try:
        return [float(cell) if cell else None for cell in cells]
    except ValueError:
        return list(cells)


def _in_order(names: set[str]) -> list[str]:
    return [*(name for name in COLUMNS if name in names), *sorted(names - COLUMNS.keys())]


def _text(value: Any) -> str:
    if value is None:
        return ''
    if isinstance(value, float):
        return repr(value).removesuffix('.0')
    return json.dumps(value) if isinstance(value, (list, Mapping, bool)) else str(value)
