"""File watch: reports when a file that is being edited has been saved completely."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable
from pathlib import Path

SETTLED_S = 0.25
"""Time in s without changes after which files count as saved."""

_ODD_SETTLED_S = 2.0  # editors may briefly delete or empty a file before they write it

_Signature = tuple[int, int, int]
_GONE: _Signature = (0, 0, 0)


class FileWatch:
    """Compares files with their state at the last check.

    Attributes:
        saved: The files that the last successful `poll` found saved.
    """

    def __init__(self, files: Iterable[Path]) -> None:
        self.saved: set[Path] = set()
        self._seen: dict[Path, _Signature] = {}
        self._changing: dict[Path, _Signature] = {}
        self._since = 0.0
        self.watch(files)

    def watch(self, files: Iterable[Path], new_are_saved: bool = False) -> None:
        """Watch these files; those not watched before count as saved now if `new_are_saved`."""
        self._seen = {
            file: self._seen.get(file, _GONE if new_are_saved else _signature(file))
            for file in files
        }

    def poll(self, now: float) -> bool:
        """Return True once after each save of a file; `now` is in s of any steady clock."""
        current = {file: _signature(file) for file in self._seen}
        if current == self._seen:
            self._changing = current
            return False
        if current != self._changing:
            self._changing, self._since = current, now
        odd = any(size == 0 for _, size, _ in current.values())
        if now - self._since < (_ODD_SETTLED_S if odd else SETTLED_S):
            return False
        self.saved = {file for file, now_is in current.items() if now_is != self._seen[file]}
        self._seen = current
        return True


def _signature(file: Path) -> _Signature:
    with contextlib.suppress(OSError):
        status = file.stat()
        return status.st_mtime_ns, status.st_size, status.st_ino
    return _GONE
