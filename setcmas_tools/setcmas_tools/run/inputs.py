"""The files that a run is given; it keeps copies, so that it can be repeated when they change."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from setcmas_ctrl.scripts.imports import with_helpers
from setcmas_simu.errors import SetcmasError
from setcmas_tools.scenario.scenario import Scenario
from setcmas_tools.scenario.scenario_files import INPUTS, OF_FILES, robots_by_text

_LARGEST_BYTES = 2_000_000


class RunInput:
    """A file that an option names, and those that it needs.

    Attributes:
        option: Name of the option.
        path: The file.
        robots: The robots that it is for; none if it is for all.
        files: The file, and if it is a script the modules of its folder that it imports.
        contents: What is in each of them.
    """

    def __init__(self, option: str, path: Path, robots: Sequence[int] = ()) -> None:
        """Read the file and what belongs to it.

        Raises:
            SetcmasError: A file cannot be read.
        """
        self.option = option
        self.path = path
        self.robots = tuple(robots)
        self.files = with_helpers(path)
        self.contents = [_read(file) for file in self.files]

    @property
    def folder(self) -> str:
        """The folder of the run in which it is kept."""
        return f'{INPUTS}/{self.option}' + (f'_{self.robots[0]}' if self.robots else '')

    def write_to(self, run: Path) -> None:
        """Write the files into the folder of a run, modules in packages into such packages.

        Raises:
            OSError: A file cannot be written.
        """
        self.write_into(run / self.folder)

    def write_into(self, folder: Path) -> None:
        """Write the files into a folder of their own.

        Raises:
            OSError: A file cannot be written.
        """
        for file, content in zip(self.files, self.contents, strict=True):
            target = folder / file.relative_to(self.path.parent)
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)


def _read(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as error:
        raise SetcmasError(f"'{file}' cannot be read: {error.strerror}") from error


def inputs_of(scenario: Scenario) -> list[RunInput]:
    """Return the scripts and files that a scenario names, each with the robots that it is for.

    Args:
        scenario: With absolute paths, as `Scenario.found` returns it.

    Raises:
        SetcmasError: A file cannot be read.
    """
    return [
        RunInput(name, Path(path), robots)
        for name in OF_FILES
        for path, robots in scenario.named(name).items()
        if Path(path).is_absolute()
    ]


def kept_record(scenario: Scenario, inputs: Iterable[RunInput]) -> dict[str, Any]:
    """Return the record of a scenario, which names its files where the folder of a run has them.

    Args:
        scenario: With absolute paths, as `Scenario.found` returns it.
        inputs: Its files.
    """
    kept = {(one.option, str(one.path)): f'{one.folder}/{one.path.name}' for one in inputs}
    return scenario.located(lambda name: lambda text: kept.get((name, text), text)).record()


def kept_inputs(folder: Path, record: Mapping[str, Any]) -> tuple[RunInput, ...]:
    """Return the inputs that the folder of a run keeps; those that have gone are left out.

    Args:
        folder: The folder.
        record: The scenario in its run.yaml.
    """
    return tuple(
        RunInput(name, folder / path, robots)
        for name in OF_FILES
        for path, robots in robots_by_text(record.get(name)).items()
        if _is_kept(folder, Path(path))
    )


def _is_kept(folder: Path, path: Path) -> bool:
    """Return whether a file, with the modules that it imports, is really in a run's inputs.

    A stranger's run.yaml may name any file: it must be a small one, reached without links.
    """
    return _is_inside(folder, path) and all(
        _is_inside(folder, file.relative_to(folder)) for file in with_helpers(folder / path)
    )


def _is_inside(folder: Path, path: Path) -> bool:
    parts = path.parts
    if parts[:1] != (INPUTS,) or '..' in parts:
        return False
    places = [folder.joinpath(*parts[:count]) for count in range(1, len(parts) + 1)]
    file = places[-1]
    linked = any(place.is_symlink() for place in places)
    return not linked and file.is_file() and file.stat().st_size <= _LARGEST_BYTES
