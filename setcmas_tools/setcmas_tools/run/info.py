"""The record of a run, `run.yaml`: what it was, with what, and how it ended."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import msgspec

from setcmas_ctrl.control.references import References
from setcmas_simu.reports.reports import ScriptFailure
from setcmas_tools.run.origin import Origin, this_origin
from setcmas_tools.run.outcome import Outcome, State
from setcmas_tools.run.record_file import read_record, write_record

FILE_NAME = 'run.yaml'


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
        parameters: Its options by name.
        seed: Seed of the random numbers of scripts and links.
        inputs: The files that it was given, by option, as paths in the folder of the run.
        references: Its task, if the law tells of one.
        started: When, such as '2026-11-21T16:02:11+0000'; None if that is not told, so that equal
            runs leave equal files.
        origin: What it was made with; None is this process.
        reloads: The later versions of its control scripts; None if there were none.
        failures: When which script failed for whom; None if none did, or if that is not told.
    """

    command: list[str] = field(default_factory=list)
    outcome: Outcome = field(default_factory=lambda: Outcome(State.COMPLETE))
    parameters: dict[str, Any] = field(default_factory=dict)
    seed: int = 0
    inputs: dict[str, str] = field(default_factory=dict)
    references: References | None = None
    started: str | None = None
    origin: Origin | None = None
    reloads: list[Reload] | None = None
    failures: list[ScriptFailure] | None = None


def write_info(info: RunInfo, folder: Path) -> None:
    """Write run.yaml, whole or not at all.

    Raises:
        OSError: The file cannot be written.
    """
    write_record(_as_dict(info), folder / FILE_NAME)


def _as_dict(info: RunInfo) -> dict[str, Any]:
    info = replace(info, origin=info.origin or this_origin())
    content = msgspec.to_builtins(info)
    content['outcome'] = {name: value for name, value in content['outcome'].items() if value}
    return {name: value for name, value in content.items() if value is not None}


def read_info(folder: Path) -> RunInfo | None:
    """Read the run.yaml of a folder; None if there is none.

    Raises:
        SetcmasError: The file cannot be read, is damaged, or is of another format.
    """
    return read_record(folder / FILE_NAME, RunInfo)
