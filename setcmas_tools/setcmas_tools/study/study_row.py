"""Row of a study: a run as it is sent to a process, and its outcome and metrics."""

from __future__ import annotations

import inspect
import os
import pickle
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from setcmas_simu.fleet.fleet import format_robots
from setcmas_simu.fleet.per_robot import mapped
from setcmas_simu.simulator.simulator_options import SimulationOptions
from setcmas_tools.measures.metrics import measure
from setcmas_tools.offline.engine import simulate
from setcmas_tools.offline.script_call import only_here
from setcmas_tools.offline.simulation import Simulation
from setcmas_tools.run.inputs import INPUTS
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_info import State
from setcmas_tools.study.study_columns import numbers_of

OF_FILES = ('algo', 'ctc', 'graph', 'model', 'poses')
"""Options that may name files."""

_LONGEST_MESSAGE = 300
_LEAST_MEMORY = 2 * 1024**3  # bytes; Python, numpy and a run of ten million states
_NOT_PASSED = ('set', 'poses', 'pose', 'random_poses')


@dataclass(frozen=True)
class Job:
    """A run of a study, as it is sent to the process that makes it.

    Attributes:
        run: Its number.
        pickled: Options of the run by name; settings of the script under 'set'.
        timeout: How long it may take in s.
        memory: How much it may take in bytes.
        files: Contents of the files that the options name, by path; None if they are on this
            machine.
    """

    run: int
    pickled: bytes
    timeout: float
    memory: int
    files: Mapping[str, bytes] | None = None

    def row(self, folder: Path) -> Row:
        """Make the run in this process; returns its row.

        Args:
            folder: Holds the files.

        Raises:
            SetcmasError: The script cannot be loaded, or an option makes no sense.
        """
        return row_of(self.run, self._parameters(folder), only_here())

    def scripts(self, folder: Path) -> set[Path]:
        """Return the folders of the scripts that the options name."""
        found: set[Path] = set()

        def note(text: str) -> str:
            found.add(Path(text).resolve().parent)
            return text

        parameters = self._parameters(folder)
        for name in OF_FILES:
            if isinstance(value := parameters.get(name), str):
                mapped(value, note, name)
        return found

    def _parameters(self, folder: Path) -> dict[str, Any]:
        return located(pickle.loads(self.pickled), lambda name: str(folder / name))


class Row(msgspec.Struct, frozen=True, kw_only=True):
    """The outcome of one run.

    Attributes:
        run: Its number.
        state: How it ended.
        robots: The robots whose script failed, such as '1-3'.
        message: The first error.
        numbers: Its metrics, by column.
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
    run = run_of(parameters, messages.append, progress)
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


def located(parameters: Mapping[str, Any], place: Callable[[str], str]) -> dict[str, Any]:
    """Return options with the paths of the files that a study keeps.

    Args:
        parameters: Options of a run by name; files that the study keeps as 'inputs/...'.
        place: Returns the path of such a file.
    """

    def path(text: str) -> str:
        return place(text) if text.startswith(f'{INPUTS}/') else text

    return {
        name: mapped(value, path, name) if name in OF_FILES and isinstance(value, str) else value
        for name, value in parameters.items()
    }


def memory_of_each(jobs: int) -> int:
    """Return the share of the memory of this machine that each of some runs may take, in bytes."""
    if not hasattr(os, 'sysconf'):
        return _LEAST_MEMORY
    physical = os.sysconf('SC_PAGE_SIZE') * os.sysconf('SC_PHYS_PAGES')
    return max(_LEAST_MEMORY, physical // jobs)


def warm_up() -> None:
    """Import and look up what runs need once, not in each copy, by a short run of our own law."""
    links = {'graph': 'ring', 'loss': 0.1, 'event_triggered': True}
    row_of(
        0, {'algo': 'consensus', 'nb_robots': 3, 'duration': 1.0, 'seed': 0, 'set': {}, **links}
    )
