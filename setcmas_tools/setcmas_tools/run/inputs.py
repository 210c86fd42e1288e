"""The files that a run is given; it keeps copies, so that it can be repeated when they change."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from setcmas_ctrl.laws.script_imports import MOST_BYTES, with_helpers
from setcmas_simu.errors import SetcmasError, file_errors
from setcmas_simu.limited_file import read_limited
from setcmas_tools.run.scenario import Scenario
from setcmas_tools.run.scenario_files import INPUTS, OF_FILES, robots_by_text


class RunInput:
    """A file that an option names, and the modules that it imports.

    Attributes:
        option: Name of the option.
        robots: The robots that it is for; none if it is for all.
        files: The file, and if it is a script the modules of its folder that it imports.
        contents: The bytes of each of them.
    """

    def __init__(self, option: str, path: Path, robots: Sequence[int] = ()) -> None:
        """Read the file and its modules, or raise SetcmasError."""
        self.option = option
        self.path = path
        self.robots = tuple(robots)
        self.files = with_helpers(path)
        self.contents = [_read(file) for file in self.files]

    @property
    def folder(self) -> str:
        """Its folder in the folder of the run."""
        return f'{INPUTS}/{self.option}' + (f'_{self.robots[0]}' if self.robots else '')

    def write_to(self, folder: Path) -> None:
        """Write the files into a folder, modules in packages into such packages.

        Raises:
            OSError: A file cannot be written.
        """
        for file, content in zip(self.files, self.contents, strict=True):
            target = folder / file.relative_to(self.path.parent)
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)


def _read(file: Path) -> bytes:
    with file_errors(f"'{file}' cannot be read"):
        return read_limited(file, MOST_BYTES)


def inputs_of(scenario: Scenario) -> list[RunInput]:
    """Return the scripts and files that a scenario names, each with the robots that it is for.

    The scenario has absolute paths, as from `Scenario.found`; SetcmasError is raised for a file
    that cannot be read.
    """
    return [
        RunInput(name, Path(path), robots)
        for name in OF_FILES
        for path, robots in scenario.named(name).items()
        if Path(path).is_absolute()
    ]


def kept_record(scenario: Scenario, inputs: Iterable[RunInput]) -> dict[str, Any]:
    """Return the record of a scenario, which names its files where the folder of a run has them.

    The scenario has absolute paths, as `Scenario.found` returns it.
    """
    kept = {(one.option, str(one.path)): f'{one.folder}/{one.path.name}' for one in inputs}
    return scenario.located(lambda name: lambda text: kept.get((name, text), text)).record()


def kept_inputs(folder: Path, record: Mapping[str, Any]) -> tuple[RunInput, ...]:
    """Return the inputs that the folder of a run keeps, for the scenario in its run.yaml.

    Those that are missing are left out. A stranger's run.yaml may name any file: it must be a
    small one in inputs/, without links.
    """
    found = []
    for name in OF_FILES:
        for text, robots in robots_by_text(record.get(name)).items():
            if _is_kept(folder, Path(text)):
                with suppress(SetcmasError):  # too large
                    found.append(RunInput(name, folder / text, robots))
    return tuple(
        one
        for one in found
        if all(_is_kept(folder, file.relative_to(folder)) for file in one.files)
    )


def _is_kept(folder: Path, path: Path) -> bool:
    parts = path.parts
    if parts[:1] != (INPUTS,) or '..' in parts:
        return False
    places = [folder.joinpath(*parts[:count]) for count in range(1, len(parts) + 1)]
    return places[-1].is_file() and not any(place.is_symlink() for place in places)
