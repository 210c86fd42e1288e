"""Files of grades that setcmas has written: a person's changes of them are not overwritten."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from pathlib import Path

_RECORD = '.written.json'


class WrittenFiles:
    """The digests of the files in a folder of grades, as they were written."""

    def __init__(self, folder: Path) -> None:
        """Read the record of the folder; without one, all its files are a person's."""
        self._folder = folder
        try:
            found = json.loads((folder / _RECORD).read_text(encoding='utf-8'))
        except (OSError, ValueError):
            found = {}
        self._digests: dict[str, str] = found if isinstance(found, dict) else {}

    def changed(self, others: Iterable[Path] = ()) -> list[Path]:
        """Return the written files, and others, that are not as setcmas has written them."""
        paths = {*(self._folder / name for name in self._digests), *others}
        return [
            path
            for path in sorted(paths)
            if path.is_file() and _digest(path) != self._digests.get(self._name(path))
        ]

    def record(self, paths: Iterable[Path]) -> None:
        """Record files as they are now, and forget those that are gone.

        Raises:
            OSError: The record cannot be written.
        """
        new = {self._name(path): _digest(path) for path in paths}
        known = self._digests | new
        self._digests = {
            one: known[one] for one in sorted(known) if (self._folder / one).is_file()
        }
        text = json.dumps(self._digests, indent=1)
        (self._folder / _RECORD).write_text(text, encoding='utf-8', newline='\n')

    def _name(self, path: Path) -> str:
        return path.relative_to(self._folder).as_posix()


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
