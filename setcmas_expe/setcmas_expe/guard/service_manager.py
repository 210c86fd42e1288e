"""What systemd is told of the guard: that it works, and that it still does."""

from __future__ import annotations

import contextlib
import os
import socket


def notify(state: str) -> None:
    """Tell systemd, if that started this process, a state of sd_notify(3), such as WATCHDOG=1."""
    address = os.environ.get('NOTIFY_SOCKET', '')
    if not address:
        return
    where = f'\0{address[1:]}' if address.startswith('@') else address
    kind = socket.SOCK_DGRAM | socket.SOCK_NONBLOCK
    # An error here is no reason to stop guarding the robot.
    with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, kind) as systemd:
        systemd.sendto(state.encode(), where)
