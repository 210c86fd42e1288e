"""The folder that a run leaves: bag/, csv/, plots/, inputs/, metrics.yaml and run.yaml."""

from __future__ import annotations

import platform
import shutil
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from importlib import metadata
from pathlib import Path
from typing import Any

import yaml

from setcmas_simu import __version__
from setcmas_simu.errors import SetcmasError
from setcmas_tools.run.files import INPUTS
from setcmas_tools.run.inputs import RunInput

_PARTS = ('bag', 'csv', 'plots', INPUTS, 'metrics.yaml', 'run.yaml')
_PACKAGES = ('numpy', 'rclpy', 'rosbags', 'matplotlib')


class RunFolder:
    """Where the parts of a run go.

    Attributes:
        path: The folder.
    """

    def __init__(self, path: Path, inputs: Sequence[RunInput] = ()) -> None:
        """Name the folder, and what the run is given; nothing is created yet."""
        self.path = path
        self._inputs = inputs

    @property
    def bag(self) -> Path:
        """The folder of the rosbag2 bag."""
        return self.path / 'bag'

    @property
    def csv(self) -> Path:
        """The folder of the CSV files."""
        return self.path / 'csv'

    @property
    def plots(self) -> Path:
        """The folder of the plots."""
        return self.path / 'plots'

    @property
    def metrics(self) -> Path:
        """The file of the metrics."""
        return self.path / 'metrics.yaml'

    def check(self, overwrite: bool) -> None:
        """See that no earlier run would be lost, and nothing that this one needs.

        Raises:
            SetcmasError: The folder holds a run and must not be overwritten, is no folder, or
                what would be overwritten is an input of the new run.
        """
        if self.path.exists() and not self.path.is_dir():
            raise SetcmasError(f"output '{self.path}' is not a folder")
        taken = [part for part in _PARTS if (self.path / part).exists()]
        if taken and 'run.yaml' not in taken:
            raise SetcmasError(
                f"output '{self.path}' holds {', '.join(taken)} and no run.yaml, so it is not a "
                'run of setcmas; name another folder'
            )
        if taken and not overwrite:
            raise SetcmasError(
                f"output '{self.path}' holds an earlier run; "
                'name another folder, or add --overwrite to replace that run'
            )
        parts = [(self.path / part).resolve() for part in taken]
        for given in self._inputs:
            if any(given.path.resolve().is_relative_to(part) for part in parts):
                raise SetcmasError(
                    f"'{given.path}' is part of the earlier run in '{self.path}' and would be "
                    'lost with it; name another output folder'
                )

    def create(self) -> None:
        """Create the folder with what the run is given, without the parts of an earlier run.

        Raises:
            SetcmasError: The folder cannot be created or emptied.
        """
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            self._empty()
            for given in self._inputs:
                given.write_to(self.path / INPUTS / given.option)
        except OSError as error:
            raise SetcmasError(
                f"output '{self.path}' cannot be written: {error.strerror}"
            ) from error

    def discard(self) -> None:
        """Remove what a run that never began has created."""
        with suppress(OSError):
            self._empty()
            self.path.rmdir()  # stays if the user has files of their own in it

    def _empty(self) -> None:
        for part in _PARTS:
            target = self.path / part
            if target.is_dir():
                shutil.rmtree(target)
            else:
                target.unlink(missing_ok=True)

    def write_record(
        self, parameters: dict[str, Any], outcome: str, seed: int, started: float | None = None
    ) -> None:
        """Write run.yaml.

        Args:
            parameters: The options of the run.
            outcome: How it ended.
            seed: Seed of the scripts' random numbers.
            started: When it started, in s since 1970; None leaves out the time, so that equal
                runs leave equal files.
        """
        record: dict[str, Any] = {
            'command': ['setcmas', *sys.argv[1:]],
            'outcome': outcome,
            'parameters': parameters,
            'inputs': {
                given.option: f'{INPUTS}/{given.option}/{given.path.name}'
                for given in self._inputs
            },
            'seed': seed,
            'versions': {'setcmas': __version__, 'python': platform.python_version()}
            | {name: version for name in _PACKAGES if (version := _version(name))},
            'host': {'name': platform.node(), 'system': platform.platform()},
        }
        if started is not None:
            record['started'] = time.strftime('%Y-%m-%dT%H:%M:%S%z', time.localtime(started))
        text = yaml.safe_dump(record, sort_keys=False, allow_unicode=True)
        (self.path / 'run.yaml').write_text(text, encoding='utf-8')

    def add_to_record(self, name: str, values: dict[str, Any]) -> None:
        """Add a part to the end of run.yaml."""
        text = yaml.safe_dump({name: values}, sort_keys=False, allow_unicode=True)
        with (self.path / 'run.yaml').open('a', encoding='utf-8') as file:
            file.write(text)


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None
