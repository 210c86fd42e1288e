"""Single keys of the terminal, without Enter, and the start key."""

from __future__ import annotations

import math
import os
import re
import select
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

try:
    import termios
except ImportError:  # Windows
    termios = None  # type: ignore[assignment]


@contextmanager
def kept_terminal(single_keys: bool = False) -> Iterator[bool]:
    """Restore the terminal's settings at the end; yield whether there is a terminal.

    Args:
        single_keys: Whether keys are to arrive at once, without Enter; Ctrl-C is still a signal.
    """
    stream = sys.__stdin__
    if termios is None or stream is None or stream.closed or not stream.isatty():
        yield False
        return
    import tty

    try:
        before = termios.tcgetattr(stream)
        if single_keys:
            tty.setcbreak(stream, termios.TCSANOW)
    except termios.error:  # the terminal has just been closed
        yield False
        return
    try:
        yield True
    finally:
        with suppress(termios.error):
            if termios.tcgetattr(stream) != before:
                termios.tcsetattr(stream, termios.TCSANOW, before)


ESC = '\x1b'

_SEQUENCE_S = 0.02
"""Time in which the rest of an arrow key arrives, whose first character is that of Esc."""

_SEQUENCES = re.compile(rf'{ESC}(\[\[?[0-?]*[ -/]*[@-~]|O[ -~])')


class Keyboard:
    """Reads single keys.

    Attributes:
        there: Whether there is a terminal; without one there are no keys.
    """

    def __init__(self, there: bool) -> None:
        self.there = there

    def pressed(self) -> str:
        """Return the keys pressed since the last call; '' if none."""
        if not self.there:
            return ''
        keys = b''
        while select.select([sys.stdin], [], [], _SEQUENCE_S if keys.endswith(b'\x1b') else 0)[0]:
            try:
                more = os.read(sys.stdin.fileno(), 64)
            except OSError:
                more = b''
            if not more:  # the terminal was closed; a signal informs the supervisor
                break
            keys += more
        return keys.decode(errors='replace')


@contextmanager
def open_keyboard() -> Iterator[Keyboard]:
    """Read single keys; restore the terminal at the end."""
    with kept_terminal(single_keys=True) as there:
        yield Keyboard(there)


def single_keys(keys: str) -> str:
    """Remove keys that send several characters, such as arrows."""
    return _SEQUENCES.sub('', keys)


ALONE_S = 0.3
"""Time in s before and after the start key without any other key."""


class StartKey:
    """Decides whether keys start the robots; all times in s on a steady clock."""

    def __init__(self, held: bool) -> None:
        """Begin with nothing pressed; a key to be held down is reported at once."""
        self._held = held
        self._other, self._waiting_since = -math.inf, math.inf

    def pressed(self, keys: str, now: float) -> bool:
        """Take the keys since the last call; return whether they start the robots."""
        if keys and not (set(keys) <= {'s', 'S'} and (self._held or len(keys) == 1)):
            self._other, self._waiting_since = now, math.inf
        elif keys and now - self._other > ALONE_S:
            self._waiting_since = min(self._waiting_since, now)
        starts = now - self._waiting_since >= (0.0 if self._held else ALONE_S)
        if starts:
            self._waiting_since = math.inf
        return starts
