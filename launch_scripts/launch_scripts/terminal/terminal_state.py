"""State of the terminal: given back as it was, whatever a script has made of it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

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
