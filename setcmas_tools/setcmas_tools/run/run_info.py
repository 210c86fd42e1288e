"""The record of a run, `run.yaml`: what it was, with what, and how it ended."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from pathlib import Path
from typing import Any

from setcmas_ctrl.control.references import References
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import format_robots
from setcmas_simu.reports.script_calls import ScriptFailure
from setcmas_tools.run.origin import Origin, this_origin
from setcmas_tools.run.record_file import builtins_of, read_record, write_record
from setcmas_tools.scenario.scenario import check_record


class State(Enum):
    """What became of a run."""

    NOT_FINISHED = 'not finished'
    """It is running, or was killed."""
    COMPLETE = 'complete'
    FAILED = 'failed'
    """It is complete, but a script failed for some robots."""
    NOT_STARTED = 'not started'
    """The robots did not start."""
    STOPPED = 'stopped'
    """The user has stopped it."""
    DIED = 'died'
    """A process of it has died."""


@dataclass(frozen=True)
class Outcome:
    """How a run ended.

    Attributes:
        state: In a word.
        failed_laws: The robots for which each control script failed at some time, by script.
        failed_conditions: The same of triggering conditions.
        detail: What there is to say beyond, such as which process died of what.
    """

    state: State
    failed_laws: dict[str, list[int]] = field(default_factory=dict)
    failed_conditions: dict[str, list[int]] = field(default_factory=dict)
    detail: str = ''

    def __str__(self) -> str:
        """Return the outcome for people, such as 'complete, but law.py failed for robot 2'."""
        failures = [
            *(f'{name} failed for {_listed(r)}' for name, r in self.failed_laws.items()),
            *(
                f'the condition {name} failed for {_listed(robots)}'
                for name, robots in self.failed_conditions.items()
            ),
        ]
        if self.state is State.FAILED:
            return f'complete, but {" and ".join(failures) or "a script failed for some robots"}'
        text = {State.STOPPED: 'stopped by the user'}.get(self.state, self.state.value)
        return f'{text}: {self.detail}' if self.detail else text

    @classmethod
    def of_failures(
        cls,
        failed_laws: Mapping[str, list[int]],
        failed_conditions: Mapping[str, list[int]] | None = None,
    ) -> Outcome:
        """Return the outcome of a run that went on to its end.

        Args:
            failed_laws: Robots by control script; robots may be none.
            failed_conditions: Robots by triggering condition.
        """
        laws = {name: robots for name, robots in failed_laws.items() if robots}
        conditions = {name: rs for name, rs in (failed_conditions or {}).items() if rs}
        return cls(State.FAILED if laws or conditions else State.COMPLETE, laws, conditions)


def _listed(robots: list[int]) -> str:
    return f'robot{"s" * (len(robots) > 1)} {format_robots(sorted(robots))}'


INFO_FILE = 'run.yaml'


@dataclass(frozen=True)
class Reload:
    """Control scripts that were loaded again in a run (`--watch`).

    Attributes:
        t: When, in s since the control laws were called first.
        works: Whether they could be loaded.
        scripts: The versions, as paths in the folder of the run.
    """

    t: float
    works: bool
    scripts: list[str]


@dataclass(frozen=True)
class RunInfo:
    """What a run was.

    Attributes:
        command: The command line; empty for a run that a script of Python has made.
        outcome: How it ended.
        scenario: What was run, as `Scenario.record` gives it; files are paths in the folder of
            the run.
        lab: What the lab of an emulated experiment decides in place of the scenario.
        references: Its task, if the law tells of one.
        started: When, such as '2026-11-21T16:02:11+0000'; None if that is not told, so that equal
            runs leave equal files.
        origin: What it was made with; None is this process.
        reloads: The later versions of its control scripts; None if there were none.
        failures: When which script failed for whom; None if none did, or if that is not told.
    """

    command: list[str] = field(default_factory=list)
    outcome: Outcome = field(default_factory=lambda: Outcome(State.COMPLETE))
    scenario: dict[str, Any] = field(default_factory=dict)
    lab: dict[str, Any] | None = None
    references: References | None = None
    started: str | None = None
    origin: Origin | None = None
    reloads: list[Reload] | None = None
    failures: list[ScriptFailure] | None = None

    @property
    def seed(self) -> int:
        """Seed of the random numbers of scripts, links and start poses."""
        return int(self.scenario.get('seed', 0))

    @property
    def parameters(self) -> dict[str, Any]:
        """The values of the scenario by name, those of the lab in place of its own."""
        return self.scenario | (self.lab or {})


def write_info(info: RunInfo, folder: Path) -> None:
    """Write run.yaml, whole or not at all.

    Raises:
        OSError: The file cannot be written.
    """
    content = builtins_of(replace(info, origin=info.origin or this_origin()))
    content['outcome'] = {name: value for name, value in content['outcome'].items() if value}
    write_record(content, folder / INFO_FILE)


def read_info(folder: Path) -> RunInfo | None:
    """Read the run.yaml of a folder; None if there is none.

    Raises:
        SetcmasError: The file cannot be read, is damaged, or is of another format.
    """
    info = read_record(folder / INFO_FILE, RunInfo)
    try:
        check_record(info.scenario if info else {})
    except SetcmasError as error:
        raise SetcmasError(f"'{folder / INFO_FILE}' is damaged: {error}") from error
    return info
