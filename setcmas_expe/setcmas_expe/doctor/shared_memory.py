"""What killed processes have left behind in shared memory, where Fast DDS keeps its messages."""

from __future__ import annotations

import contextlib
import fcntl
import re
from pathlib import Path

from setcmas_expe.doctor.findings import NOTE, OK, Finding

_WHAT = 'shared memory'
_SEGMENT = re.compile(r'fastrtps_[0-9a-f]{16}')
_MANY_MB = 50.0


def stale_segments(folder: Path) -> list[Path]:
    """Return the segments whose process has ended: living ones hold a lock on `<segment>_el`."""
    return [
        path
        for path in sorted(folder.glob('fastrtps_*'))
        if _SEGMENT.fullmatch(path.name) and not _is_locked(Path(f'{path}_el'))
    ]


def _is_locked(path: Path) -> bool:
    try:
        file = path.open('rb')
    except FileNotFoundError:
        return False
    except OSError:  # another user's: not ours to judge
        return True
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except OSError:
            return True
    return False


def shared_memory_finding(folder: Path = Path('/dev/shm')) -> Finding:
    """Return whether killed processes have left segments behind."""
    stale = stale_segments(folder)
    size = 0
    for path in stale:
        with contextlib.suppress(OSError):  # somebody may clean up meanwhile
            size += path.stat().st_size
    megabytes = size / 1e6
    if not stale:
        return Finding(OK, _WHAT, 'nothing left behind by killed processes')
    found = f'{len(stale)} leftovers of killed processes, {megabytes:.0f} MB, in {folder}'
    if megabytes < _MANY_MB:
        return Finding(OK, _WHAT, found)
    return Finding(NOTE, _WHAT, found, 'fastdds shm clean removes them; so does a restart')
