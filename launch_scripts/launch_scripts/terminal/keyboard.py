"""Keys of the terminal one by one, without Enter."""

from __future__ import annotations

import os
import re
import sys
from contextlib import suppress
from typing import Any

ESC = '\x1b'

_SEQUENCE_S = 0.02
"""Within this time the rest of an arrow key comes, which begins as Esc does."""

_SEQUENCES = re.compile(rf'{ESC}(\[\[?[0-?]*[ -/]*[@-~]|O[ -~])')


class Keyboard:
    """Reads single keys while it is open; gives the terminal back as it was.

    Ctrl-C goes on to be a signal. Without a terminal there are no keys.

    Attributes:
        there: Whether there is a terminal.
    """

    def __init__(self) -> None:
        """Look whether standard input is a terminal."""
        self.there = sys.stdin is not None and sys.stdin.isatty()
        self._before: list[Any] | None = None

    def __enter__(self) -> Keyboard:
        """Take the terminal's keys as they come."""
        if self.there:
            import termios
            import tty

            with suppress(termios.error):  # the terminal has just been closed
                self._before = termios.tcgetattr(sys.stdin)
                tty.setcbreak(sys.stdin, termios.TCSANOW)
        return self

    def __exit__(self, *exc_info: object) -> None:
        """Give the terminal back."""
        if self._before is not None:
            import termios

            with suppress(termios.error):
                termios.tcsetattr(sys.stdin, termios.TCSANOW, self._before)

    def pressed(self) -> str:
        """Return the keys that were pressed since the last call; empty if none."""
        if self._before is None:
            return ''
        import select

        keys = b''
        while select.select([sys.stdin], [], [], _SEQUENCE_S if keys.endswith(b'\x1b') else 0)[0]:
            try:
                more = os.read(sys.stdin.fileno(), 64)
            except OSError:
                more = b''
            if not more:  # the terminal has been closed; a signal tells the supervisor
                break
            keys += more
        return keys.decode(errors='replace')


def single_keys(keys: str) -> str:
    """Return keys without those that send several characters, such as arrows."""
    return _SEQUENCES.sub('', keys)
