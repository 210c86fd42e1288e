"""Watch over files that are being edited: whole, saved versions only."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable
from pathlib import Path

SETTLED_S = 0.25
"""For how long in s files must stay as they are before they count as saved."""

_ODD_SETTLED_S = 2.0  # editors delete or empty a file for a moment before they write it

_Signature = tuple[int, int, int]
_GONE: _Signature = (0, 0, 0)


class FileWatch:
    """Compares files with what they were when they were last looked at.

    Attributes:
        saved: The files that had been saved when `poll` last said so.
    """

    def __init__(self, files: Iterable[Path]) -> None:
        """Start with the files as they are."""
        self.saved: set[Path] = set()
        self._seen: dict[Path, _Signature] = {}
        self._changing: dict[Path, _Signature] = {}
        self._since = 0.0
        self.watch(files)

    def watch(self, files: Iterable[Path], new_are_saved: bool = False) -> None:
        """Watch these files; those that are watched already keep what they are compared with.

        Args:
            files: The files.
            new_are_saved: Whether one that was not watched before counts as saved now.
        """
        self._seen = {
            file: self._seen.get(file, _GONE if new_are_saved else _signature(file))
            for file in files
        }

    def poll(self, now: float) -> bool:
        """Return whether a file has been saved, once for each time.

        Args:
            now: Time of a clock of the caller's in s.
        """
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
