"""Files that may come from a stranger, read within limits; files written whole or not at all."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from io import TextIOWrapper
from pathlib import Path
from typing import BinaryIO

from setcmas_simu.errors import SetcmasError


def open_limited(path: Path, most: int) -> BinaryIO:
    """Open a regular file of at most `most` bytes for reading.

    Raises:
        OSError: It cannot be opened.
        SetcmasError: It is larger, or is a pipe, a socket or a device.
    """
    # A pipe without a writer would block.
    file = open(path, 'rb', opener=lambda p, flags: os.open(p, flags | _AT_ONCE))  # noqa: SIM115
    status = os.fstat(file.fileno())
    if stat.S_ISREG(status.st_mode) and status.st_size <= most:
        return file
    file.close()
    if stat.S_ISREG(status.st_mode):
        raise _too_large(path, most)
    raise SetcmasError(f"'{path}' is not a regular file")


def read_limited(path: Path, most: int) -> bytes:
    """Return the content of a regular file of at most `most` bytes; errors as `open_limited`."""
    with open_limited(path, most) as file:
        content = file.read(most + 1)
    if len(content) > most:  # files in /proc have size 0
        raise _too_large(path, most)
    return content


@contextmanager
def written_whole(path: Path) -> Iterator[TextIOWrapper]:
    """Open a text file (UTF-8) for writing; it replaces `path` at the end, if all went well.

    Raises:
        OSError: It cannot be written, such as on a full disk.
    """
    part = path.with_name(f'.{path.name}.part')
    try:
        with part.open('w', encoding='utf-8', newline='') as file:
            yield file
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def write_together(texts: Mapping[Path, str]) -> None:
    """Write text files (UTF-8) and their folders: all files, or none if the disk is full.

    Raises:
        OSError: They cannot be written.
    """
    parts = {path: path.with_name(f'.{path.name}.part') for path in texts}
    try:
        for path, part in parts.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            part.write_text(texts[path], encoding='utf-8', errors='replace', newline='')
        for path, part in parts.items():
            part.replace(path)
    finally:
        for part in parts.values():
            part.unlink(missing_ok=True)


_AT_ONCE = getattr(os, 'O_NONBLOCK', 0)  # Windows has no such pipes


def _too_large(path: Path, most: int) -> SetcmasError:
    return SetcmasError(f"'{path}' is too large; it must have at most {most:,} bytes")
