"""Processes that a script has detached from its own: found again, and ended with the rest."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from contextlib import suppress
from pathlib import Path

_PR_SET_CHILD_SUBREAPER = 36


def adopt_orphans() -> None:
    """Become the parent of whatever is left by processes that this one has started (Linux)."""
    if sys.platform == 'linux':
        ctypes.CDLL(None).prctl(_PR_SET_CHILD_SUBREAPER, 1)


def children() -> set[int]:
    """Return the process numbers of this process's children; none where that cannot be told."""
    found: set[int] = set()
    for tasks in Path('/proc/self/task').glob('*/children'):
        with suppress(OSError):
            found |= {int(word) for word in tasks.read_text().split()}
    return found


def end_orphans(known: set[int]) -> None:
    """End the children of this process but for known ones, and the children that those leave."""
    while strangers := children() - known:
        for pid in strangers:
            with suppress(ProcessLookupError, PermissionError):
                os.kill(pid, signal.SIGKILL)
            with suppress(ChildProcessError):
                os.waitpid(pid, 0)
