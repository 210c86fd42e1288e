"""When robots sent their states in an event-triggered run, read from its triggers.csv."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.errors import SetcmasError

Floats = NDArray[np.float64]

FILE_NAME = 'triggers.csv'
COLUMNS = ('t', 'robot', 'sent')


def trigger_times(folder: Path) -> dict[int, Floats]:
    """Return the times at which each robot sent its state.

    Args:
        folder: The folder of the CSV files.

    Returns:
        For each robot times in s, as in fleet.csv; empty if the run was not event-triggered.

    Raises:
        SetcmasError: The file is damaged.
    """
    path = folder / FILE_NAME
    if not path.is_file():
        return {}
    try:
        with path.open(encoding='utf-8-sig', newline='') as file:
            rows = [[float(row[name]) for name in COLUMNS] for row in csv.DictReader(file)]
    except (OSError, ValueError, KeyError, TypeError, csv.Error) as error:
        raise SetcmasError(
            f"'{path}' is damaged; accepted are the columns {','.join(COLUMNS)}"
        ) from error
    t, robot, sent = np.array(rows, dtype=float).reshape(-1, len(COLUMNS)).T
    return {int(i): np.sort(t[(robot == i) & (sent > 0)]) for i in np.unique(robot)}
