"""Keys of the terminal one by one, without Enter, and the start key."""

from __future__ import annotations

import math
import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

try:
    import termios
except ImportError:  # Windows
    termios = None  # type: ignore[assignment]


@contextmanager
def kept_terminal() -> Iterator[None]:
    """Give the terminal back as it was before: a script may have called `stty`."""
    stream = sys.__stdin__
    if termios is None or stream is None or stream.closed or not stream.isatty():
        yield
        return
    before = termios.tcgetattr(stream)
    try:
        yield
    finally:
        with suppress(termios.error):  # it has been closed
            if termios.tcgetattr(stream) != before:
                termios.tcsetattr(stream, termios.TCSADRAIN, before)


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


ALONE_S = 0.3
"""Time in s before and after the key in which no other may be pressed."""


class StartKey:
    """Judges the keys of a terminal; all times in s on a steady clock."""

    def __init__(self, held: bool) -> None:
        """Begin with nothing pressed.

        Args:
            held: Whether the key counts only while it is held down. It is told at once then: a
                second press is needed anyway, and its release must not be late.
        """
        self._held = held
        self._other, self._waiting_since = -math.inf, math.inf

    def pressed(self, keys: str, now: float) -> bool:
        """Take the keys since the last call, as they came; returns whether they start robots."""
        if keys and not (set(keys) <= {'s', 'S'} and (self._held or len(keys) == 1)):
            self._other, self._waiting_since = now, math.inf
        elif keys and now - self._other > ALONE_S:
            self._waiting_since = min(self._waiting_since, now)
        starts = now - self._waiting_since >= (0.0 if self._held else ALONE_S)
        if starts:
            self._waiting_since = math.inf
        return starts
