"""References of a task: waypoints, a reference point, places in a formation; read from a law."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_ctrl.laws.script_errors import StopCall, describe_failure, short_repr
from setcmas_simu.errors import SetcmasError, it_must_be

Kind = Callable[[Any], Any]
"""Converts a reference to numbers and lists; raises ValueError with what it must be."""

Wanted = float | list[list[float]]
"""The distance between any two robots in m, or the shape: a point for each of robots 1, 2, ..."""

REACHED_M = 0.10
"""Distance at which a waypoint counts as reached if the law does not say, as in nav_wp."""

_LARGEST_M = 1e6  # a coordinate of a box


@dataclass(frozen=True)
class References:
    """The goal of the robots.

    Attributes:
        task: Name of the task.
        values: Numbers and lists of numbers by their names in the task.
    """

    task: str
    values: dict[str, Any] = field(default_factory=dict)

    def encoded(self) -> str:
        """Return a line of JSON."""
        return json.dumps(asdict(self), ensure_ascii=False, separators=(',', ':'))

    @classmethod
    def decoded(cls, text: str) -> References:
        """Read the references from a line of JSON.

        Raises:
            ValueError: The line has no references.
        """
        try:
            message = json.loads(text)
        except (ValueError, RecursionError):
            message = None
        if not (isinstance(message, dict) and isinstance(message.get('task'), str)):
            raise ValueError('it must be a JSON object with task, a name')
        values = message.get('values')
        if not (isinstance(values, dict) and all(map(_is_value, values.values()))):
            raise ValueError('values must be numbers, or lists of numbers, by name')
        return cls(message['task'], values)


def not_understood(error: ValueError) -> str:
    """Return a warning about a message on /task that is not understood."""
    return f'/task is not understood and ignored: {error}'


def references_of(names: Mapping[str, Any], script: Path, nb_robots: int) -> References | None:
    """Return task and references among a script's top-level names; None if it has no task.

    Raises:
        SetcmasError: The task is unknown, or a reference is missing or invalid.
    """
    task = names.get('task')
    if task is None:
        return None
    if not isinstance(task, str):
        raise SetcmasError(
            f'{script.name}: task is {short_repr(task)}; it must be the name of a task'
        )
    if task not in TASKS:
        known = it_must_be(f'one of {", ".join(TASKS)}', task, TASKS)
        raise SetcmasError(f"{script.name}: unknown task '{task}'{known}")
    own = _own_references(names.get('references'), nb_robots, script)
    given, values = {**DEFAULTS.get(task, {}), **names, **own}, {}
    for name, kind in TASKS[task].items():
        if name not in given:
            raise SetcmasError(f"{script.name} defines no {name}, which task '{task}' needs")
        if (value := given[name]) is None:
            continue
        try:
            values[name] = kind(value)
        except (TypeError, ValueError) as error:
            what = f'{script.name}: {name} is {short_repr(value)}; {error}'
            raise SetcmasError(what) from error
    return References(task, values)


def references_of_fleet(
    scripts: Iterable[tuple[Mapping[str, Any], Path]], nb_robots: int, warn: Callable[[str], None]
) -> References | None:
    """Return the references of the first script with a task; mistakes give a warning.

    Scripts of the ROS 1 stack may use the name `task` for something else; they run anyway. Each
    script is given by its top-level names and its file.
    """
    for names, script in scripts:
        try:
            if found := references_of(names, script, nb_robots):
                return found
        except SetcmasError as error:
            warn(f'{error}; the run continues without a task')
            return None
    return None


def _own_references(given: Any, nb_robots: int, path: Path) -> Mapping[str, Any]:
    if callable(given):
        try:
            given = given(nb_robots)
        except (KeyboardInterrupt, StopCall):
            raise
        except BaseException as error:  # a user's function may raise anything
            raise SetcmasError(describe_failure(error, path)) from error
    if given is not None and not isinstance(given, Mapping):
        raise SetcmasError(
            f'{path.name}: references are a {type(given).__name__}; they must be a dictionary '
            'of names and values'
        )
    return given or {}


def _is_value(value: Any, levels: int = 3) -> bool:
    """Return whether a reference has finite numbers only, in at most three levels of lists."""
    if isinstance(value, list):
        return levels > 0 and all(_is_value(item, levels - 1) for item in value)
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return is_number and abs(value) <= sys.float_info.max  # not NaN


def number(value: Any) -> float:
    """Return a finite number, or raise ValueError."""
    try:
        result = float(value)
    except (TypeError, ValueError):
        result = np.nan
    if not np.isfinite(result):
        raise ValueError('it must be a number')
    return result


def points(value: Any) -> list[list[float]]:
    """Return a non-empty list of points in the plane, or raise ValueError."""
    try:
        result = np.array(value, dtype=float)
    except (TypeError, ValueError):
        result = np.empty(0)
    if result.shape[1:] != (2,) or not result.size or not np.isfinite(result).all():
        raise ValueError('it must be points [[x, y], ...]')
    return result.tolist()  # type: ignore[no-any-return]


def robots(value: Any) -> list[int]:
    """Return a list of numbers of robots, or raise ValueError."""
    if isinstance(value, (list, tuple)) and all(type(one) is int for one in value):
        return list(value)
    raise ValueError('it must be numbers of robots [1, 2, ...]')


def distance_or_shape(value: Any) -> Wanted:
    """Return a distance, or the points of a shape, or raise ValueError."""
    return points(value) if isinstance(value, (list, tuple, np.ndarray)) else number(value)


def box(value: Any) -> list[list[float]]:
    """Return the two corners of a box, or raise ValueError."""
    corners = points(value)
    is_box = len(corners) == 2 and (np.diff(corners, axis=0) > 0).all()
    if not is_box or np.max(corners) > _LARGEST_M:
        raise ValueError('it must be the corners [[left, bottom], [right, top]] of a box (m)')
    return corners


_WAYPOINTS: dict[str, Kind] = {'WPL': points, 'REACHED': number}

TASKS: dict[str, dict[str, Kind]] = {
    'alignment': {},
    'consensus': {},
    'coverage': {'BOX': box},
    'distances': {'D': distance_or_shape, **_WAYPOINTS},
    'formation': {'PLACES': points, **_WAYPOINTS},
    'resilience': {'REBELS': robots},
    'tracking': {'R': number, 'W': number},
    'waypoints': _WAYPOINTS,
}
"""The references of each task, by their names in a law, and how they are converted."""

_LED = {'WPL': None, 'REACHED': REACHED_M}
DEFAULTS: dict[str, dict[str, Any]] = {
    'distances': _LED,
    'formation': _LED,
    'waypoints': {'REACHED': REACHED_M},
}
"""The values of optional references of tasks; None omits the reference."""
