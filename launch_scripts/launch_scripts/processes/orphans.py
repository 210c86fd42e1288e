"""Orphans: processes that the processes of a command leave behind (Linux)."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from contextlib import suppress
from pathlib import Path

_PR_SET_CHILD_SUBREAPER = 36


def adopt_orphans() -> None:
    """Become the parent of processes that descendants of this one leave behind."""
    if sys.platform == 'linux':
        ctypes.CDLL(None).prctl(_PR_SET_CHILD_SUBREAPER, 1)


def children() -> set[int]:
    """Return the process IDs of the children of this process."""
    found: set[int] = set()
    for tasks in Path('/proc/self/task').glob('*/children'):
        with suppress(OSError):
            found |= {int(word) for word in tasks.read_text().split()}
    return found


def end_orphans(known: set[int]) -> None:
    """Kill the children of this process but for known ones, and the children that those leave."""
    while strangers := children() - known:
        for pid in strangers:
            with suppress(ProcessLookupError, PermissionError):
                os.kill(pid, signal.SIGKILL)
            with suppress(ChildProcessError):
                os.waitpid(pid, 0)
