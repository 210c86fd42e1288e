"""The record of a run, `run.yaml`: what it was, with what, and how it ended."""

from __future__ import annotations

import os
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import msgspec
import yaml

from setcmas_ctrl.task.references import References
from setcmas_simu.errors import SetcmasError
from setcmas_tools.run.origin import Origin, this_origin
from setcmas_tools.run.outcome import Outcome, State

FILE_NAME = 'run.yaml'
FORMAT = 1


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


def write_info(info: RunInfo, folder: Path) -> None:
    """Write run.yaml, whole or not at all.

    Raises:
        OSError: The file cannot be written.
    """
    text = yaml.safe_dump(_as_dict(info), sort_keys=False, allow_unicode=True)
    part = folder / f'.{FILE_NAME}.part'
    with part.open('w', encoding='utf-8', newline='\n') as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    part.replace(folder / FILE_NAME)


def _as_dict(info: RunInfo) -> dict[str, Any]:
    info = replace(info, origin=info.origin or this_origin())
    content = {'format': FORMAT, **msgspec.to_builtins(info)}
    content['outcome'] = {name: value for name, value in content['outcome'].items() if value}
    return {name: value for name, value in content.items() if value is not None}


def read_info(folder: Path) -> RunInfo | None:
    """Read the run.yaml of a folder; None if there is none.

    Raises:
        SetcmasError: The file cannot be read, is damaged, or is of another format.
    """
    path = folder / FILE_NAME
    try:
        content = yaml.safe_load(path.read_text(encoding='utf-8'))
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        reason = ' '.join(str(error).split())
        raise SetcmasError(f"'{path}' cannot be read: {reason}") from error
    given = content.get('format', 'none') if isinstance(content, dict) else 'none'
    if given != FORMAT:
        raise SetcmasError(f"'{path}' has format {given}; this setcmas reads format {FORMAT} only")
    try:
        return msgspec.convert(content, RunInfo)
    except msgspec.ValidationError as error:
        raise SetcmasError(f"'{path}' is damaged: {error}") from error
