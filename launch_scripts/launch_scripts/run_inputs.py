"""The files that a run is given; it keeps copies, so that it can be repeated when they change."""

from __future__ import annotations

import argparse
import shutil
from pathlib import Path

from setcmas_ctrl.communication import graph_file
from setcmas_ctrl.communication_options import communication_values
from setcmas_ctrl.helper_modules import helper_modules


class RunInput:
    """A file that an option names, and those that it needs.

    Attributes:
        option: Name of the option.
        path: The file.
        files: The file, and if it is a script the modules beside it that it imports.
    """

    def __init__(self, option: str, path: Path) -> None:
        """Look for what belongs to the file."""
        self.option = option
        self.path = path
        self.files = [path, *(helper_modules(path) if option in ('algo', 'ctc') else [])]

    def copy_to(self, folder: Path) -> None:
        """Copy the files to a folder, modules in packages to the same packages there.

        Raises:
            OSError: A file cannot be read or written.
        """
        for file in self.files:
            target = folder / file.relative_to(self.path.parent)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, target)


def run_inputs(args: argparse.Namespace, script: Path, lab: Path | None = None) -> list[RunInput]:
    """Return what a run is given.

    Args:
        args: Parsed options of a run.
        script: Its control script.
        lab: The lab file of an emulated experiment.

    Raises:
        SetcmasError: There is no such condition.
    """
    named = {
        'algo': script,
        'ctc': communication_values(args)['ctc'],
        'graph': graph_file(args.graph),
        'poses': args.poses,
        'lab': lab,
    }
    return [RunInput(option, Path(path)) for option, path in named.items() if path is not None]
