"""What an offline run was given by a script of Python, for its record."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_ctrl.communication.communication_options import Condition, Graph
from setcmas_ctrl.communication.communication_settings import graph_file
from setcmas_ctrl.control.control_law import ControlLaw
from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.per_robot import format_per_robot
from setcmas_tools.offline.fleet_laws import Algo
from setcmas_tools.run.inputs import RunInput


def given_files(condition: Path | None, graph: Graph) -> list[RunInput]:
    """Return the files of communication that a run is given.

    Args:
        condition: The script of its triggering condition, if it is one.
        graph: A preset, a file, or an adjacency matrix.

    Raises:
        SetcmasError: A file cannot be read.
    """
    file = graph_file(graph) if isinstance(graph, (str, Path)) else None
    named = {'ctc': condition, 'graph': file}
    return [RunInput(option, path) for option, path in named.items() if path]


def given_scripts(laws: Sequence[ControlLaw]) -> list[RunInput]:
    """Return the control scripts of robots 1, 2, ...

    Raises:
        SetcmasError: A file cannot be read.
    """
    paths = [law.path if law.is_script else None for law in laws]
    if len({*paths}) == 1:
        return [RunInput('algo', path) for path in paths[:1] if path]
    return [
        RunInput('algo', path, [robot for robot, own in enumerate(paths, 1) if own == path])
        for path in dict.fromkeys(paths)
        if path
    ]


def name_of(given: Algo | None) -> str | None:
    """Return what scripts or functions are called in the record."""
    if isinstance(given, Mapping):
        return format_per_robot({robot: str(name_of(own)) for robot, own in given.items()})
    if callable(given):
        return str(getattr(given, '__name__', 'function'))
    return None if given is None else str(given)


def graph_entry(graph: Graph) -> Any:
    """Return a graph as plain values."""
    return str(graph) if isinstance(graph, (str, Path)) else np.asarray(graph).tolist()


def condition_name(condition: Condition) -> str:
    """Return what a triggering condition is called in messages."""
    return Path(name_of(condition) or 'by default').name


def pose_options(poses: Floats) -> list[str]:
    """Return start poses, shape (3, N), as `--pose` takes them."""
    return [
        f'{robot}:{x!r},{y!r},{theta!r}'
        for robot, (x, y, theta) in enumerate(poses.T.tolist(), start=1)
    ]


def script_entry(laws: Sequence[ControlLaw]) -> str | None:
    """Return what the record says of the scripts of robots 1, 2, ...; None if they are functions.

    One script is told with its path, several by their names.
    """
    scripts = list(dict.fromkeys(law.path for law in laws if law.is_script))
    if len(scripts) == 1:
        return str(scripts[0])
    return ', '.join(script.stem for script in scripts) or None


def failures(names: Sequence[str], robots: Sequence[int]) -> dict[str, list[int]]:
    """Return those of some robots that each script is of; the first name is that of robot 1."""
    failed: dict[str, list[int]] = {}
    for robot in robots:
        failed.setdefault(Path(names[robot - 1]).name, []).append(robot)
    return failed
