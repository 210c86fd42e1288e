"""Files that the options of a study name: found, read, and kept in its folder."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from pathlib import Path

from setcmas_ctrl.communication.options import find_condition
from setcmas_ctrl.communication.settings import graph_description, graph_file
from setcmas_ctrl.control.law_scripts import LawScripts
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.per_robot import mapped
from setcmas_simu.robots.models import is_file
from setcmas_tools.run.inputs import RunInput


@dataclass
class KeptFiles:
    """The files of a study.

    Attributes:
        texts: What stands for each value that names files, by option: with 'inputs/...' in place
            of the files.
        originals: Where each 'inputs/...' was found, absolute.
        contents: What is kept, by 'inputs/...'; with the modules that scripts import.
    """

    texts: dict[str, dict[str, str]] = field(default_factory=dict)
    originals: dict[str, Path] = field(default_factory=dict)
    contents: dict[str, bytes] = field(default_factory=dict)

    @property
    def digests(self) -> dict[str, str]:
        """SHA-256 of what is kept."""
        return {name: hashlib.sha256(self.contents[name]).hexdigest() for name in self.contents}

    def add(self, option: str, value: str, exercise: bool = False) -> None:
        """Keep the files that a value of an option names, if it names any.

        Raises:
            SetcmasError: There is no such file, or another one of that name is kept already.
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
                    f"'{file}' and '{self.originals.get(name, name)}' would both be kept as "
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
    """Return a value with the absolute paths of the files that it names."""
    if option == 'algo':
        return LawScripts(value, exercise).text
    if option == 'model':
        return mapped(value, _file, option)
    if option == 'ctc':
        return str(find_condition(value, exercise))
    if option == 'graph':
        graph_description(value)  # which tells what graphs there are
    if option in ('poses', 'cases') or (option == 'graph' and graph_file(value)):
        return str(Path(value).resolve())
    return value


def _file(name: str) -> str:
    return str(Path(name).resolve()) if is_file(name) else name
