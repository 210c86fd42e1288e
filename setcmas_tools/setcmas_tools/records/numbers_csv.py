"""CSV files of numbers under fixed columns."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError


def write_numbers(
    path: Path,
    names: Sequence[str],
    columns: Sequence[Floats | NDArray[np.int64]],
    formats: Sequence[str],
) -> None:
    """Write columns, each in its format.

    Raises:
        OSError: The file cannot be written.
    """
    row = ','.join(f'{{:{form}}}' for form in formats) + '\n'
    with path.open('w', encoding='utf-8', newline='') as file:
        file.write(','.join(names) + '\n')
        file.writelines(map(row.format, *(column.tolist() for column in columns)))


def read_numbers(path: Path, names: Sequence[str]) -> Floats | None:
    """Return the rows of a file, shape (rows, columns); None if there is no such file.

    Raises:
        SetcmasError: The file cannot be read, or has other columns.
    """
    try:
        with path.open(encoding='utf-8-sig', newline='') as file:
            header, *rows = csv.reader(file)
            if header != list(names) or any(len(row) != len(names) for row in rows):
                raise ValueError
            return np.array(rows, dtype=float).reshape(-1, len(names))
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError, csv.Error, ValueError) as error:
        raise SetcmasError(
            f"'{path}' is damaged; it must have the columns {','.join(names)}"
        ) from error
