"""Browser that shows a served page: the addresses of the page, and when to open it."""

from __future__ import annotations

import os
import socket
import sys
import time
import webbrowser
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from setcmas_simu.option_groups import Options, flag, option
from setcmas_simu.option_kinds import Kind, Whole

EVERYWHERE = {'0.0.0.0': '127.0.0.1', '::': '::1'}
"""Addresses that mean all of a machine's, and how the machine itself is reached then."""
HOST = '127.0.0.1'
PORT = 8080
_RECONNECT_S = 2.5
"""Time in s for a page left open by an earlier run to reconnect by itself."""


def own_address() -> str:
    """Return the address of this machine in its network; '' without a network."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(('192.0.2.1', 9))  # sends nothing; the system chooses the way
            return str(probe.getsockname()[0])
        except OSError:
            return ''


@dataclass(frozen=True, kw_only=True)
class BrowserOptions(Options):
    """Where the page is served, and what its buttons do."""

    TITLE: ClassVar[str] = 'page'

    host: str = option(
        Kind(metavar='ADDRESS'),
        'address of the page; with 0.0.0.0 others on the network can open it, and whoever has '
        'the token in the address can also press its buttons',
        default=HOST,
        default_text=f'{HOST}, this machine only',
    )
    port: int = option(
        Whole(1, 65535, metavar='PORT'),
        'port of the page; a free one if it is taken',
        default=PORT,
    )
    read_only: bool = flag('no buttons that start, pause, stop or reset robots')

    @property
    def is_local(self) -> bool:
        """Whether only this machine can open the page."""
        return self.host in ('127.0.0.1', 'localhost', '::1')


def has_display(environment: Mapping[str, str], platform: str) -> bool:
    """Return whether windows can be opened at all, from `os.environ` and `sys.platform`."""
    if platform in ('win32', 'darwin'):
        return True
    return bool(environment.get('DISPLAY') or environment.get('WAYLAND_DISPLAY'))


def may_open_windows(environment: Mapping[str, str], platform: str) -> bool:
    """Return whether the user sits in front of the display: not over ssh, not in CI."""
    elsewhere = ('SSH_CONNECTION', 'SSH_TTY', 'CI')
    return has_display(environment, platform) and not any(map(environment.get, elsewhere))


class Opener:
    """Opens the page in a browser unless one reconnects first."""

    def __init__(self, url: str) -> None:
        self._url = url
        self._begin = time.monotonic()
        self._opened = not may_open_windows(os.environ, sys.platform)

    def look(self, is_shown: bool) -> None:
        """Open the page if no browser shows it and the time to reconnect is over."""
        self._opened = self._opened or is_shown
        if not self._opened and time.monotonic() - self._begin > _RECONNECT_S:
            self._opened = True
            webbrowser.open(self._url)
