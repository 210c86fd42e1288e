"""The files that a run is given; it keeps copies, so that it can be repeated when they change."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path

from setcmas_ctrl.communication.options import CommunicationOptions
from setcmas_ctrl.communication.settings import graph_file
from setcmas_ctrl.scripts.helper_modules import helper_modules
from setcmas_simu.errors import SetcmasError

INPUTS = 'inputs'
"""The folder of a run with copies of the files that it was given, in a folder for each option."""

_SCRIPTS = ('algo', 'ctc')


class RunInput:
    """A file that an option names, and those that it needs.

    Attributes:
        option: Name of the option.
        path: The file.
        files: The file, and if it is a script the modules beside it that it imports.
    """

    def __init__(self, option: str, path: Path) -> None:
        """Read the file and what belongs to it.

        Raises:
            SetcmasError: A file cannot be read.
        """
        self.option = option
        self.path = path
        self.files = [path, *(helper_modules(path) if option in _SCRIPTS else [])]
        self._contents = [_read(file) for file in self.files]

    def write_to(self, folder: Path) -> None:
        """Write the files into a folder, modules in packages into the same packages there.

        Raises:
            OSError: A file cannot be written.
        """
        for file, content in zip(self.files, self._contents, strict=True):
            target = folder / file.relative_to(self.path.parent)
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)


def _read(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as error:
        raise SetcmasError(f"'{file}' cannot be read: {error.strerror}") from error


def run_inputs(args: argparse.Namespace, script: Path, lab: Path | None = None) -> list[RunInput]:
    """Return what a run is given.

    Args:
        args: Parsed options of a run.
        script: Its control script.
        lab: The lab file of an emulated experiment.

    Raises:
        SetcmasError: There is no such condition, or a file cannot be read.
    """
    named = {
        'algo': script,
        'ctc': CommunicationOptions.of(args).found(args.exercise).ctc,
        'graph': graph_file(args.graph),
        'poses': args.poses,
        'lab': lab,
    }
    return [RunInput(option, Path(path)) for option, path in named.items() if path is not None]


def kept_inputs(folder: Path, kept: Mapping[str, str]) -> tuple[RunInput, ...]:
    """Return the inputs that the folder of a run keeps; those that have gone are left out.

    Args:
        folder: The folder.
        kept: Paths in the folder, by option.
    """
    paths = {option: folder / path for option, path in kept.items()}
    return tuple(RunInput(option, path) for option, path in paths.items() if path.is_file())
