"""Early start of the process of an offline run, before it has anything to do.

Its imports take as long as those of the command: early, both are made at the same time.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
from pathlib import Path

from launch_scripts.processes.node_commands import OFFLINE_WORKER, node_command
from launch_scripts.processes.supervision.orphans import adopt_orphans, children


class OfflineStart:
    """A process that waits for its job, or ends with this one.

    Attributes:
        process: The process; a line on its standard input tells it to begin.
        folder: Its folder, as `setcmas_tools.offline.worker` tells.
        strangers: Processes that this one had started before.
    """

    def __init__(self) -> None:
        """Start the process."""
        self.strangers = children()
        adopt_orphans()
        self._temporary = tempfile.TemporaryDirectory(prefix='setcmas_')
        self.folder = Path(self._temporary.name)
        self.process = subprocess.Popen(
            node_command(OFFLINE_WORKER, [str(self.folder)]),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=os.environ | {'PYTHONUNBUFFERED': '1'},
            start_new_session=True,  # Ctrl-C is answered here
        )

    def clean_up(self) -> None:
        """Remove the folder."""
        self._temporary.cleanup()


_waiting: list[OfflineStart] = []


def start_early() -> None:
    """Start a process for the next offline run."""
    _waiting.append(OfflineStart())


def started() -> OfflineStart:
    """Return the process that was started early, or else a new one."""
    return _waiting.pop() if _waiting else OfflineStart()
