"""The files that a run is given; it keeps copies, so that it can be repeated when they change."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from setcmas_ctrl.communication.communication_options import CommunicationOptions
from setcmas_ctrl.communication.communication_settings import graph_file
from setcmas_ctrl.control.law_scripts import LawScripts
from setcmas_ctrl.scripts.imports import with_helpers
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import format_robots
from setcmas_simu.fleet.per_robot import is_per_robot, parse_per_robot
from setcmas_simu.robots.models import is_file, model_names

INPUTS = 'inputs'
"""The folder of a run with copies of the files that it was given, in a folder for each option."""


class RunInput:
    """A file that an option names, and those that it needs.

    Attributes:
        option: Name of the option.
        path: The file.
        robots: The robots that it is for; none if it is for all.
        files: The file, and if it is a script the modules beside it that it imports.
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


def run_inputs(
    args: argparse.Namespace, scripts: LawScripts, lab: Path | None = None
) -> list[RunInput]:
    """Return what a run is given.

    Args:
        args: Parsed options of a run.
        scripts: Its control scripts.
        lab: The lab file of an emulated experiment.

    Raises:
        SetcmasError: There is no such condition, or a file cannot be read.
    """
    named = {
        'ctc': CommunicationOptions.of(args).found(args.exercise).ctc,
        'graph': graph_file(args.graph),
        'poses': args.poses,
        'lab': lab,
    }
    return [
        *law_inputs(scripts),
        *model_inputs(args.model, args.nb_robots),
        *(RunInput(option, Path(path)) for option, path in named.items() if path is not None),
    ]


def law_inputs(scripts: LawScripts) -> list[RunInput]:
    """Return the control scripts of a run.

    Raises:
        SetcmasError: A file cannot be read.
    """
    return [RunInput('algo', path, robots) for path, robots in scripts.robots_of.items()]


def model_inputs(model: str | None, nb_robots: int) -> list[RunInput]:
    """Return the robot scripts and model files of a run.

    Raises:
        SetcmasError: A file cannot be read.
    """
    names = model_names(model, nb_robots)
    robots_of = {name: [r for r, own in enumerate(names, 1) if own == name] for name in names}
    everywhere = model is None or not is_per_robot(model)
    return [
        RunInput('model', Path(name), () if everywhere else robots)
        for name, robots in robots_of.items()
        if is_file(name)
    ]


def entries(inputs: Iterable[RunInput]) -> dict[str, str]:
    """Return where the folder of a run keeps its inputs, as the options themselves would say."""
    found: dict[str, list[str]] = {}
    for given in inputs:
        robots = f'{format_robots(list(given.robots))}:' if given.robots else ''
        found.setdefault(given.option, []).append(f'{robots}{given.folder}/{given.path.name}')
    return {option: ','.join(texts) for option, texts in found.items()}


def kept_inputs(folder: Path, kept: Mapping[str, str]) -> tuple[RunInput, ...]:
    """Return the inputs that the folder of a run keeps; those that have gone are left out.

    Args:
        folder: The folder.
        kept: Paths in the folder, by option, as `entries` gives them.
    """
    found = []
    for option, text in kept.items():
        robots_of: dict[str, list[int]] = {}
        if is_per_robot(text):
            for robot, path in parse_per_robot(text, option).items():
                robots_of.setdefault(path, []).append(robot)
        for path, robots in (robots_of or {text: []}).items():
            if (folder / path).is_file():
                found.append(RunInput(option, folder / path, robots))
    return tuple(found)
