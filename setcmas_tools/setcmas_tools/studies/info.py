"""The record of a study, `study.yaml`: what would repeat it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec
import yaml

from setcmas_simu.errors import SetcmasError
from setcmas_tools.run.origin import Origin

FILE_NAME = 'study.yaml'
FORMAT = 1


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
    content = {'format': FORMAT, **msgspec.to_builtins(info)}
    part = folder / f'.{FILE_NAME}.part'
    text = yaml.safe_dump(content, sort_keys=False, allow_unicode=True)
    part.write_text(text, encoding='utf-8', newline='\n')
    part.replace(folder / FILE_NAME)


def read_info(folder: Path) -> StudyInfo | None:
    """Read the study.yaml of a folder; None if there is none.

    Raises:
        SetcmasError: The file cannot be read, is damaged, or is of another format.
    """
    path = folder / FILE_NAME
    try:
        content = yaml.safe_load(path.read_text(encoding='utf-8'))
        if not isinstance(content, Mapping) or content.get('format') != FORMAT:
            raise SetcmasError(f"'{path}' must have format {FORMAT}")
        return msgspec.convert(content, StudyInfo)
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError, yaml.YAMLError, msgspec.ValidationError) as error:
        raise SetcmasError(f"'{path}' is damaged: {' '.join(str(error).split())}") from error
