"""Row of a study: what became of one run, and what it is measured by."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import msgspec

from setcmas_simu.fleet.fleet import format_robots
from setcmas_simu.simulator.simulator_options import SimulationOptions
from setcmas_tools.measures.metrics import measure
from setcmas_tools.offline.engine import simulate
from setcmas_tools.offline.simulation import Simulation
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_info import State
from setcmas_tools.study.study_columns import numbers_of

_LONGEST_MESSAGE = 300
_NOT_PASSED = ('set', 'poses', 'pose', 'random_poses')


class Row(msgspec.Struct, frozen=True, kw_only=True):
    """What became of one run.

    Attributes:
        run: Its number.
        state: How it ended.
        robots: The robots whose script failed, such as '1-3'.
        message: The first thing that went wrong.
        numbers: What it is measured by, by column.
    """

    run: int
    state: State
    robots: str = ''
    message: str = ''
    numbers: dict[str, float | None] = {}


def run_of(
    parameters: Mapping[str, Any],
    warn: Callable[[str], None],
    progress: Callable[[float], object] | None = None,
) -> Run:
    """Make the run that parameters describe.

    Args:
        parameters: Options of a run by name; settings of the script under 'set'.
        warn: Shows messages about a failing law.
        progress: As for `simulate`.

    Raises:
        SetcmasError: The script cannot be loaded, or an option makes no sense.
    """
    return simulate(**arguments_of(parameters, warn, progress))


def arguments_of(
    parameters: Mapping[str, Any],
    warn: Callable[[str], None],
    progress: Callable[[float], object] | None = None,
) -> dict[str, Any]:
    """Return the arguments of `simulate`, from those of `run_of`."""
    given = {name: value for name, value in parameters.items() if name not in _NOT_PASSED}
    poses = parameters.get('poses')
    if poses is None or isinstance(poses, str):
        poses = simulated_robots(parameters).start_poses(parameters['nb_robots'])
    settings = parameters['set']
    return {**given, 'poses': poses, 'settings': settings, 'warn': warn, 'progress': progress}


def simulation_of(arguments: Mapping[str, Any]) -> Simulation:
    """Return the run that arguments of `simulate` describe, checked.

    Raises:
        SetcmasError: One makes no sense.
    """
    bound = inspect.signature(simulate).bind(**arguments)
    bound.apply_defaults()
    return Simulation(**bound.arguments)


def simulated_robots(parameters: Mapping[str, Any]) -> SimulationOptions:
    """Return the options of the robots of a run.

    Raises:
        SetcmasError: One makes no sense.
    """
    poses = parameters.get('poses')
    file, pose = Path(poses) if isinstance(poses, str) else None, parameters.get('pose') or ()
    return SimulationOptions.among({**parameters, 'poses': file, 'pose': tuple(pose)})


def row_of(
    number: int,
    parameters: Mapping[str, Any],
    progress: Callable[[float], object] | None = None,
) -> Row:
    """Make a run and return its row.

    Args:
        number: That of the run.
        parameters: As for `run_of`.
        progress: As for `simulate`.

    Raises:
        SetcmasError: The script cannot be loaded, or an option makes no sense.
    """
    messages: list[str] = []
    return row_of_run(number, run_of(parameters, messages.append, progress), messages)


def row_of_run(number: int, run: Run, messages: list[str]) -> Row:
    """Return the row of a run.

    Args:
        number: That of the run.
        run: The run.
        messages: What there was to tell; takes metrics that fail.
    """
    failed = list(run.outcome.failed_laws.values())
    failed += run.outcome.failed_conditions.values()
    return Row(
        run=number,
        state=run.outcome.state,
        robots=format_robots(sorted({robot for robots in failed for robot in robots})),
        message=one_line(messages[0]) if messages else '',
        numbers=numbers_of(measure(run, messages.append)),
    )


def one_line(message: str) -> str:
    """Return a message in one line that is not too long for a table."""
    words = ' '.join(message.split())
    return words if len(words) <= _LONGEST_MESSAGE else f'{words[: _LONGEST_MESSAGE - 1]}…'
