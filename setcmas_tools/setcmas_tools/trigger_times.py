"""When robots communicated in an event-triggered run, read from the CSV files of the topics."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from setcmas_simu import topics
from setcmas_simu.errors import SetcmasError

Floats = NDArray[np.float64]


def trigger_times(folder: Path, robots: list[int]) -> dict[int, Floats]:
    """Return the times at which each robot communicated.

    Args:
        folder: The folder of the CSV files.
        robots: Numbers of the robots.

    Returns:
        For each robot that has a file, times in s from the first command, as in fleet.csv; empty
        if the run was not event-triggered.

    Raises:
        SetcmasError: A file is damaged.
    """
    triggers: dict[int, Floats] = {}
    for robot in robots:
        path = _csv(folder, robot, topics.TRIG_EVENT)
        if path.is_file():
            rows = _read(path, 't', 'data')
            triggers[robot] = rows[rows[:, 1] > 0, 0]
    start = _first_command(folder, robots) if triggers else 0.0
    return {robot: times - start for robot, times in triggers.items()}


def _first_command(folder: Path, robots: list[int]) -> float:
    """Return when the first cmd_vel came, in s from the bag's start; 0 in runs without a bag."""
    paths = [_csv(folder, robot, topics.CMD_VEL) for robot in robots]
    tables = [_read(path, 't') for path in paths if path.is_file()]
    return min((float(rows[0, 0]) for rows in tables if len(rows)), default=0.0)


def _csv(folder: Path, robot: int, topic: str) -> Path:
    return folder / f'{topics.robot_name(robot)}_{topic}.csv'


def _read(path: Path, *columns: str) -> Floats:
    try:
        with path.open(encoding='utf-8-sig', newline='') as file:
            rows = [[float(row[name]) for name in columns] for row in csv.DictReader(file)]
    except (OSError, ValueError, KeyError, TypeError, csv.Error) as error:
        raise SetcmasError(
            f"'{path}' cannot be read ({error}); expected are numbers in {', '.join(columns)}"
        ) from error
    return np.array(rows, dtype=float).reshape(-1, len(columns))
