"""Output of processes, line by line: whole lines, with the process's name before them."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from io import TextIOBase
from typing import IO

Stream = IO[str] | TextIOBase

_LONGEST_LINE = 16 * 1024
# What the nodes' logger puts first, and what the user sees instead.
_SEVERITIES = {'DEBUG': 'debug: ', 'INFO': '', 'WARN': 'warning: ', 'ERROR': 'error: '}

LOG_FORMAT = '{severity}|{message}'
"""For RCUTILS_CONSOLE_OUTPUT_FORMAT, so that `LineBuffer` can tell severities."""


class LineBuffer:
    """Cuts what a process writes to one of its outputs into lines."""

    def __init__(self, prefix: str, stream: Stream) -> None:
        """Prepare.

        Args:
            prefix: Stands before each line.
            stream: Where the lines are to be shown.
        """
        self.stream = stream
        self._prefix = prefix
        self._rest = b''

    def feed(self, data: bytes) -> Iterator[str]:
        """Yield the lines that are complete with these bytes; no bytes mean the end."""
        self._rest += data
        *lines, self._rest = self._rest.split(b'\n')
        if self._rest and (not data or len(self._rest) > _LONGEST_LINE):
            lines.append(self._rest)
            self._rest = b''
        for line in lines:
            yield self._prefix + _readable(line.decode(errors='replace').rstrip('\r'))


def _readable(line: str) -> str:
    severity, bar, message = line.partition('|')
    return _SEVERITIES[severity] + message if bar and severity in _SEVERITIES else line


def write_line(line: str, stream: Stream) -> None:
    """Write a line in one piece."""
    stream.write(f'{line}\n')
    stream.flush()


def warn(message: str) -> None:
    """Show an error or a warning of the command itself."""
    write_line(message, sys.stderr)


def teller(verb: str) -> Callable[[str], None]:
    """Return what shows a message of a verb."""
    return lambda message: warn(f'setcmas {verb}: {message}')
