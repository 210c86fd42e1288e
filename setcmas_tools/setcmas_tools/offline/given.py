"""What an offline run was given by a script of Python, for its record."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.communication.options import Condition, Graph
from setcmas_ctrl.communication.settings import graph_file
from setcmas_tools.run.inputs import RunInput


def given_files(script: Path | None, condition: Path | None, graph: Graph) -> tuple[RunInput, ...]:
    """Return the files that a run is given.

    Args:
        script: Its control script; None for a function.
        condition: The script of its triggering condition, if it is one.
        graph: A preset, a file, or an adjacency matrix.

    Raises:
        SetcmasError: A file cannot be read.
    """
    file = graph_file(graph) if isinstance(graph, (str, Path)) else None
    named = {'algo': script, 'ctc': condition, 'graph': file}
    return tuple(RunInput(option, path) for option, path in named.items() if path)


def name_of(given: str | Path | Callable[..., Any] | None) -> str | None:
    """Return what a script or a function is called in the record."""
    if callable(given):
        return str(getattr(given, '__name__', 'function'))
    return None if given is None else str(given)


def graph_entry(graph: Graph) -> Any:
    """Return a graph as plain values."""
    return str(graph) if isinstance(graph, (str, Path)) else np.asarray(graph).tolist()


def condition_name(condition: Condition) -> str:
    """Return what a triggering condition is called in messages."""
    return Path(name_of(condition) or 'by default').name


def pose_options(poses: NDArray[np.float64]) -> list[str]:
    """Return start poses, shape (3, N), as `--pose` takes them."""
    return [
        f'{robot}:{x!r},{y!r},{theta!r}'
        for robot, (x, y, theta) in enumerate(poses.T.tolist(), start=1)
    ]
