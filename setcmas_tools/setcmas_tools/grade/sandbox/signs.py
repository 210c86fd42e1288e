"""Signs of a submission seen from outside: what it writes, waits for, and where it is."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

from setcmas_tools.grade.sandbox.channel import ChannelError
from setcmas_tools.offline.where import WHERE, told_places

_MOST_WRITTEN = 1 << 26  # bytes in all files of its home
_MOST_FILES = 1000
_MOST_TOLD = 1 << 13


def check_written(home: Path) -> None:
    """See that there is not too much in the home of a submission.

    Raises:
        ChannelError: There is.
    """
    count = size = 0
    for folder, _, names in os.walk(home):
        for name in names:
            count += 1
            with suppress(OSError):
                size += Path(folder, name).lstat().st_size
            if count > _MOST_FILES or size > _MOST_WRITTEN:
                raise ChannelError(
                    f'the script wrote more than {_MOST_WRITTEN >> 20} MB or {_MOST_FILES} files'
                )


def hindered(process: int) -> float:
    """Return how long a process could have run but had to wait for a core, in s (Linux).

    On a machine with other work nobody is late for the work of others.
    """
    try:
        return int(Path(f'/proc/{process}/schedstat').read_text().split()[1]) / 1e9
    except (OSError, ValueError, IndexError):
        return 0.0


def told_size(home: Path) -> int:
    """Return how much a submission has told of where it is, in bytes."""
    try:
        return (home / WHERE).lstat().st_size
    except OSError:
        return 0


def last_place(home: Path) -> tuple[str, int]:
    """Return file and line of the script that a submission told last; ('', 0) if none."""
    with suppress(OSError), (home / WHERE).open('rb') as file:
        file.seek(max(0, told_size(home) - _MOST_TOLD))
        for path, line in told_places(file.read(_MOST_TOLD).decode(errors='replace')):
            if path.is_relative_to(home):
                return path.name, line
    return '', 0
