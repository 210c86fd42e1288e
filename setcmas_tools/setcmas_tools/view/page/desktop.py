"""Desktop of the user: whether windows can be shown on it."""

from __future__ import annotations

import os
import sys
import time
import webbrowser
from collections.abc import Mapping

_RECONNECT_S = 2.5
"""How long a page that is still open from the last time gets to come back by itself."""


def has_display(environment: Mapping[str, str], platform: str) -> bool:
    """Return whether windows can be opened at all.

    Args:
        environment: Variables, as in os.environ.
        platform: As sys.platform.
    """
    if platform in ('win32', 'darwin'):
        return True
    return bool(environment.get('DISPLAY') or environment.get('WAYLAND_DISPLAY'))


def may_open_windows(environment: Mapping[str, str], platform: str) -> bool:
    """Return whether the user sits in front of the display: not over ssh, not in CI."""
    elsewhere = ('SSH_CONNECTION', 'SSH_TTY', 'CI')
    return has_display(environment, platform) and not any(map(environment.get, elsewhere))


class Opener:
    """Opens the page in a browser if nobody looks at it soon."""

    def __init__(self, url: str) -> None:
        """Give a page that is open already its time from now on."""
        self._url = url
        self._begin = time.monotonic()
        self._opened = not may_open_windows(os.environ, sys.platform)

    def look(self, looked_at: bool) -> None:
        """Open the page, if it is time to and nobody looks at it."""
        self._opened = self._opened or looked_at
        if not self._opened and time.monotonic() - self._begin > _RECONNECT_S:
            self._opened = True
            webbrowser.open(self._url)
