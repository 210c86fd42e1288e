"""Locks on the robots that a process of this host simulates; they end with the process."""

from __future__ import annotations

import contextlib
import os
import tempfile
from pathlib import Path

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import robots_in_words

_ENTRY_SIZE = 16  # bytes


class RobotLocks:
    """Holds the locks of some robots in one ROS domain until the process ends.

    A lock covers the robot's entry in one file per domain, which names its holder; any number of
    robots needs only one descriptor.
    """

    def __init__(self, robots: list[int], domain: str) -> None:
        """Lock robots (sorted numbers) in a ROS domain.

        Raises:
            SetcmasError: Another process holds one of them.
        """
        self._file: int | None = None
        # A file of another user cannot be opened; then the ROS graph must do.
        with contextlib.suppress(PermissionError):
            if hasattr(os, 'O_NOFOLLOW'):  # Windows has no such locks
                flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW
                self._file = os.open(_path(domain), flags, 0o666)
        taken = {robot: holder for robot in robots if (holder := self._take(robot))}
        if taken:
            self.release()
            raise SetcmasError(
                f'{robots_in_words(list(taken), "are")} already simulated by process '
                f'{next(iter(taken.values()))} in ROS domain {domain}: stop the other simulator, '
                'or set another ROS_DOMAIN_ID'
            )

    def release(self) -> None:
        """Release the locks."""
        if self._file is not None:
            os.close(self._file)
            self._file = None

    def _take(self, robot: int) -> str | None:
        """Lock a robot; return the holder if another process has the lock, else None."""
        if self._file is None:
            return None
        import fcntl  # POSIX only

        place = robot * _ENTRY_SIZE
        try:
            fcntl.lockf(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB, _ENTRY_SIZE, place)
        except OSError:
            holder = os.pread(self._file, _ENTRY_SIZE, place).decode(errors='replace').strip()
            return holder or 'of another user'
        os.pwrite(self._file, f'{os.getpid():<{_ENTRY_SIZE}}'.encode(), place)
        return None


def _path(domain: str) -> Path:
    # Hosts made of network namespaces share a disk, but not their robots.
    network = 0
    with contextlib.suppress(OSError):
        network = Path('/proc/self/ns/net').stat().st_ino
    return Path(tempfile.gettempdir()) / f'setcmas_{network}_{domain}.locks'
