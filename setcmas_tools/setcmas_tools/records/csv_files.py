"""CSV files under fixed columns."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TypeVar

from setcmas_simu.errors import SetcmasError

Row = TypeVar('Row')


def write_lines(path: Path, columns: tuple[str, ...], lines: Iterable[str]) -> None:
    """Write the names of columns, and lines with their ends.

    Raises:
        OSError: The file cannot be written.
    """
    with path.open('w', encoding='utf-8', newline='') as file:
        file.write(','.join(columns) + '\n')
        file.writelines(lines)


def read_rows(
    path: Path,
    columns: tuple[str, ...],
    parsed: Callable[[list[str]], Row],
    further: tuple[str, ...] = (),
) -> list[Row] | None:
    """Return the rows of a file; None if there is no such file.

    Args:
        path: The file.
        columns: The names that its first line must have.
        parsed: Turns cells, one for each column, into a row; raises ValueError.
        further: Names that may follow, all or none.

    Raises:
        SetcmasError: The file cannot be read or is damaged.
    """
    try:
        with path.open(encoding='utf-8-sig', newline='') as file:
            header, *rows = csv.reader(file)
            if tuple(header) not in (columns, columns + further):
                raise ValueError
            if any(len(row) != len(header) for row in rows):
                raise ValueError
            return [parsed(row) for row in rows]
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError, csv.Error, ValueError) as error:
        raise SetcmasError(
            f"'{path}' is damaged; it must have the columns {','.join(columns)}"
        ) from error
