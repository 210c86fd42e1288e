"""Locks on the robots that a process of this host simulates; they vanish with it."""

from __future__ import annotations

import contextlib
import fcntl
import os
import tempfile
from pathlib import Path

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import format_robots
from setcmas_simu.fleet.topics import robot_name


class RobotLocks:
    """Holds the locks of some robots in one ROS domain until the process ends."""

    def __init__(self, robots: list[int], domain: str) -> None:
        """Take the locks.

        Args:
            robots: Numbers of the robots, sorted.
            domain: The ROS domain.

        Raises:
            SetcmasError: Another process holds one of them.
        """
        self._files: list[int] = []
        taken = {robot: holder for robot in robots if (holder := self._take(robot, domain))}
        if taken:
            self.release()
            raise SetcmasError(
                f'robots {format_robots(list(taken))} are already simulated by process '
                f'{next(iter(taken.values()))} in ROS domain {domain}: stop the other simulator, '
                'or set another ROS_DOMAIN_ID'
            )

    def release(self) -> None:
        """Give the locks back."""
        while self._files:
            os.close(self._files.pop())

    def _take(self, robot: int, domain: str) -> str | None:
        """Return who holds the lock of a robot; None if it is ours now."""
        try:
            file = os.open(_path(robot, domain), os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
        except PermissionError:  # another user's file: what is on the ROS graph decides
            return None
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            holder = os.read(file, 32).decode(errors='replace').strip()
            os.close(file)
            return holder or 'of somebody else'
        os.ftruncate(file, 0)
        os.write(file, f'{os.getpid()}\n'.encode())
        self._files.append(file)
        return None


def _path(robot: int, domain: str) -> Path:
    # Hosts made of network namespaces share a disk, not their robots.
    network = 0
    with contextlib.suppress(OSError):
        network = Path('/proc/self/ns/net').stat().st_ino
    name = f'setcmas_{network}_{domain}_{robot_name(robot)}.lock'
    return Path(tempfile.gettempdir()) / name
