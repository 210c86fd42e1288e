"""Job of a study: one run, as it is sent to the process that makes it."""

from __future__ import annotations

import os
import pickle
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from setcmas_simu.fleet.per_robot import mapped
from setcmas_tools.run.inputs import INPUTS

_LEAST_MEMORY = 2 * 1024**3  # bytes; Python, numpy and a run of ten million states
OF_FILES = ('algo', 'ctc', 'graph', 'model', 'poses')
"""Options that may name files."""


@dataclass(frozen=True)
class Job:
    """One run.

    Attributes:
        run: Its number.
        pickled: Options of the run by name; settings of the script under 'set'.
        timeout: How long it may take in s.
        memory: How much it may take in bytes.
        files: The files that the options name, by the paths that they name; None if they are
            there already.
    """

    run: int
    pickled: bytes
    timeout: float
    memory: int
    files: Mapping[str, bytes] | None = None

    def unpack(self, folder: Path) -> None:
        """Write the files into a folder, those that are not there yet."""
        for name, content in (self.files or {}).items():
            if not (folder / name).exists():
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                (folder / name).write_bytes(content)

    def parameters(self, folder: Path) -> dict[str, Any]:
        """Return the options, with the paths of files that `unpack` has written into a folder."""
        return located(pickle.loads(self.pickled), lambda name: str(folder / name))


def located(parameters: Mapping[str, Any], place: Callable[[str], str]) -> dict[str, Any]:
    """Return options with the files that a study keeps where they are.

    Args:
        parameters: Options of a run by name; files that the study keeps as 'inputs/...'.
        place: Returns the path of such a file.
    """

    def path(text: str) -> str:
        return place(text) if text.startswith(f'{INPUTS}/') else text

    return {
        name: mapped(value, path, name) if name in OF_FILES and isinstance(value, str) else value
        for name, value in parameters.items()
    }


def memory_of_each(jobs: int) -> int:
    """Return the share of this machine's memory that each of so many runs may take, in bytes."""
    if not hasattr(os, 'sysconf'):
        return _LEAST_MEMORY
    physical = os.sysconf('SC_PAGE_SIZE') * os.sysconf('SC_PHYS_PAGES')
    return max(_LEAST_MEMORY, physical // jobs)
