"""Files of a study: study.yaml, and the files that its options name."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from setcmas_ctrl.communication.communication_settings import (
    find_condition,
    graph_description,
    graph_file,
)
from setcmas_ctrl.control.law_scripts import LawScripts
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.per_robot import mapped
from setcmas_tools.run.inputs import RunInput
from setcmas_tools.run.run_info import Origin, read_record, write_record

FILE_NAME = 'study.yaml'


@dataclass(frozen=True)
class StudyInfo:
    """Content of study.yaml.

    Attributes:
        scenario: The common scenario of its runs, as from `Scenario.record`.
        vary: Values of each varied name, or a random distribution as text.
        cases: Names in its file of cases.
        seeds: Number of seeds; the first one is the scenario's.
        success: Condition for a success.
        files: Paths of stored files in the folder, by option and original text.
        digests: SHA-256 of these files, by path.
        metrics: SHA-256 of the source of its own metrics, by name.
        origin: Versions that made it; None if not recorded yet.
    """

    scenario: dict[str, Any]
    vary: dict[str, Any] = field(default_factory=dict)
    cases: list[str] = field(default_factory=list)
    seeds: int = 1
    success: str | None = None
    files: dict[str, dict[str, str]] = field(default_factory=dict)
    digests: dict[str, str] = field(default_factory=dict)
    metrics: dict[str, str] = field(default_factory=dict)
    origin: Origin | None = None


def write_info(info: StudyInfo, folder: Path) -> None:
    """Write study.yaml completely or not at all.

    Raises:
        OSError: The file cannot be written.
    """
    write_record(info, folder / FILE_NAME)


def read_info(folder: Path) -> StudyInfo | None:
    """Read the study.yaml of a folder; return None if there is none.

    Raises:
        SetcmasError: The file cannot be read, is damaged, or has another format.
    """
    return read_record(folder / FILE_NAME, StudyInfo)


@dataclass
class KeptFiles:
    """Files that a study stores.

    Attributes:
        texts: Replacement of each value that names files, by option: with 'inputs/...' instead
            of the files.
        originals: Original absolute path of each 'inputs/...'.
        contents: Content by 'inputs/...', including modules that scripts import.
    """

    texts: dict[str, dict[str, str]] = field(default_factory=dict)
    originals: dict[str, Path] = field(default_factory=dict)
    contents: dict[str, bytes] = field(default_factory=dict)

    @property
    def digests(self) -> dict[str, str]:
        """SHA-256 of the stored files."""
        return {name: hashlib.sha256(self.contents[name]).hexdigest() for name in self.contents}

    def add(self, option: str, value: str, exercise: bool = False) -> None:
        """Store the files that a value of an option names, if any.

        Raises:
            SetcmasError: A file does not exist, or another file of this name is already stored.
        """
        found = _found(option, value, exercise)
        kept = mapped(found, lambda path: self._kept(option, path), option)
        if kept != value:
            self.texts.setdefault(option, {})[value] = kept

    def _kept(self, option: str, text: str) -> str:
        path = Path(text)
        if not path.is_absolute():
            return text
        given = RunInput(option, path)
        for file, content in zip(given.files, given.contents, strict=True):
            name = f'{given.folder}/{file.relative_to(path.parent).as_posix()}'
            if self.contents.setdefault(name, content) != content:
                raise SetcmasError(
                    f"'{file}' and '{self.originals.get(name, name)}' would both be stored as "
                    f"'{name}'; rename one"
                )
            self.originals.setdefault(name, file)
        return f'{given.folder}/{path.name}'

    def write_to(self, folder: Path) -> None:
        """Write the files into the folder of a study.

        Raises:
            OSError: A file cannot be written.
        """
        for name, content in self.contents.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)


def _found(option: str, value: str, exercise: bool) -> str:
    """Return a value with absolute paths of its files."""
    if option == 'algo':
        return LawScripts(value, exercise).text
    if option == 'model':
        return mapped(value, _file, option)
    if option == 'ctc':
        return str(find_condition(value, exercise))
    if option == 'graph':
        graph_description(value)  # its error lists all graphs
    if option in ('poses', 'cases') or (option == 'graph' and graph_file(value)):
        return str(Path(value).resolve())
    return value


def _file(name: str) -> str:
    return str(Path(name).resolve()) if Path(name).suffix else name  # a built-in has none
