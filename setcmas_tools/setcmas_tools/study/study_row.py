"""Row of a study: the outcome and metrics of a run, and the job that makes it."""

from __future__ import annotations

import os
import pickle
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import msgspec

from setcmas_simu.fleet.fleet import format_robots
from setcmas_tools.measures.metric import Metric
from setcmas_tools.measures.metrics import measure
from setcmas_tools.offline.engine import simulate
from setcmas_tools.offline.script_call import only_here
from setcmas_tools.run.run_info import State
from setcmas_tools.scenario.scenario import Scenario
from setcmas_tools.scenario.scenario_files import INPUTS, OF_FILES, Place
from setcmas_tools.study.study_columns import numbers_of

_LONGEST_MESSAGE = 300
_LEAST_MEMORY = 2 * 1024**3  # bytes; Python, numpy and a run of ten million states


@dataclass(frozen=True)
class Job:
    """A run of a study, for the process that makes it.

    Attributes:
        pickled: Its scenario, and further metrics by name.
        timeout: Its time limit in s.
        memory: Its memory limit in bytes.
        files: Contents of its files by path; None if they are on this machine.
    """

    run: int
    pickled: bytes
    timeout: float
    memory: int
    files: Mapping[str, bytes] | None = None

    def row(self, folder: Path) -> Row:
        """Make the run in this process, and return its row.

        Args:
            folder: Folder of the files.

        Raises:
            SetcmasError: The script cannot be loaded, or an option is invalid.
        """
        scenario, metrics = self._work(folder)
        return row_of(self.run, scenario, only_here(), metrics)

    def scripts(self, folder: Path) -> set[Path]:
        """Return the folders of the scripts that the options name."""
        scenario, _ = self._work(folder)
        return {Path(text).resolve().parent for name in OF_FILES for text in scenario.named(name)}

    def _work(self, folder: Path) -> tuple[Scenario, dict[str, Metric]]:
        scenario, metrics = pickle.loads(self.pickled)
        return scenario.located(kept(lambda name: str(folder / name))), metrics


class Row(msgspec.Struct, frozen=True, kw_only=True):
    """The outcome of one run.

    Attributes:
        state: How it ended.
        robots: The robots whose script failed, such as '1-3'.
        numbers: Its metrics, by column.
    """

    run: int
    state: State
    robots: str = ''
    message: str = ''
    numbers: dict[str, float | None] = {}


def row_of(
    number: int,
    scenario: Scenario,
    progress: Callable[[float], object] | None = None,
    metrics: Mapping[str, Metric] | None = None,
) -> Row:
    """Make a run and return its row.

    Args:
        number: Its number.
        scenario: Its scenario.
        progress: As for `simulate`.
        metrics: Further metrics by name.

    Raises:
        SetcmasError: A script cannot be loaded, or a value is invalid.
    """
    messages: list[str] = []
    run = simulate(scenario, warn=messages.append, progress=progress)
    failed = list(run.outcome.failed_laws.values())
    failed += run.outcome.failed_conditions.values()
    numbers = numbers_of(measure(run, messages.append, metrics))
    return Row(
        run=number,
        state=run.outcome.state,
        robots=format_robots(sorted({robot for robots in failed for robot in robots})),
        message=one_line(messages[0]) if messages else '',
        numbers=numbers,
    )


def one_line(message: str) -> str:
    """Return a message in one line that is not too long for a table."""
    words = ' '.join(message.split())
    return words if len(words) <= _LONGEST_MESSAGE else f'{words[: _LONGEST_MESSAGE - 1]}…'


def kept(place: Callable[[str], str]) -> Callable[[str], Place]:
    """Return a function for `Scenario.located` that finds files stored as 'inputs/...'.

    Args:
        place: Returns the path of such a file.
    """
    return lambda _: lambda text: place(text) if text.startswith(f'{INPUTS}/') else text


def memory_of_each(jobs: int) -> int:
    """Return the memory limit of each of several simultaneous runs, in bytes."""
    if not hasattr(os, 'sysconf'):
        return _LEAST_MEMORY
    physical = os.sysconf('SC_PAGE_SIZE') * os.sysconf('SC_PHYS_PAGES')
    return max(_LEAST_MEMORY, physical // jobs)


def warm_up() -> None:
    """Import modules and fill caches by a short run of a built-in law."""
    links = {'graph': 'ring', 'loss': 0.1, 'event_triggered': True}
    row_of(0, Scenario.of('consensus', nb_robots=3, duration=1.0, **links))
