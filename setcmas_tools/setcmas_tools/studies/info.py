"""Record of a study, `study.yaml`: all it takes to repeat it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec

from setcmas_tools.run.origin import Origin
from setcmas_tools.run.record_file import read_record, write_record

FILE_NAME = 'study.yaml'


@dataclass(frozen=True)
class StudyInfo:
    """What a study is.

    Attributes:
        parameters: Options of all its runs by name; settings of the script under 'set'.
        vary: The values of each name that is varied, or the draw of each run as a text.
        cases: The names in its file of cases.
        seeds: Number of seeds; the first one is among the parameters.
        success: What makes a run a success.
        files: Where the folder keeps the files that options name, by option and name.
        digests: SHA-256 of these files, by their places.
        origin: What it was made with; None if it is not recorded yet.
    """

    parameters: dict[str, Any]
    vary: dict[str, Any] = field(default_factory=dict)
    cases: list[str] = field(default_factory=list)
    seeds: int = 1
    success: str | None = None
    files: dict[str, dict[str, str]] = field(default_factory=dict)
    digests: dict[str, str] = field(default_factory=dict)
    origin: Origin | None = None


def write_info(info: StudyInfo, folder: Path) -> None:
    """Write study.yaml, whole or not at all.

    Raises:
        OSError: The file cannot be written.
    """
    write_record(msgspec.to_builtins(info), folder / FILE_NAME)


def read_info(folder: Path) -> StudyInfo | None:
    """Read the study.yaml of a folder; None if there is none.

    Raises:
        SetcmasError: The file cannot be read, is damaged, or is of another format.
    """
    return read_record(folder / FILE_NAME, StudyInfo)
