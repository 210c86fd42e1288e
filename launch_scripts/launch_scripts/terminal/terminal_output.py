"""Output of processes in the terminal, line by line, without ever blocking the launcher."""

from __future__ import annotations

import contextlib
import io
import os
import queue
import sys
import threading
from collections.abc import Callable, Iterator
from io import TextIOBase
from typing import IO, cast

Stream = IO[str] | TextIOBase

_LONGEST_LINE = 16 * 1024
# Severities from the nodes' logger, and their text for the user.
_SEVERITIES = {'DEBUG': 'debug: ', 'INFO': '', 'WARN': 'warning: ', 'ERROR': 'error: '}

LOG_FORMAT = '{severity}|{message}'
"""For RCUTILS_CONSOLE_OUTPUT_FORMAT, so that `LineBuffer` finds severities."""


class LineBuffer:
    """Splits the output of a process into lines."""

    def __init__(self, prefix: str, stream: Stream) -> None:
        self.stream = stream
        self._prefix = prefix
        self._rest = b''

    def feed(self, data: bytes) -> Iterator[str]:
        """Yield the lines that these bytes complete; no bytes mean the end."""
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


def warner(verb: str) -> Callable[[str], None]:
    """Return a function that shows messages of a verb."""
    return lambda message: warn(f'setcmas {verb}: {message}')


_CAPACITY = 2000  # pieces of text
_FLUSH_S = 1.0


class OutputQueue:
    """Writes texts to file descriptors, in order, from its own thread.

    Attributes:
        broken: Whether a reader is gone (closed terminal or pipe).
    """

    def __init__(self) -> None:
        self.broken = False
        self._dropped = 0
        self._texts: queue.Queue[tuple[int, str] | None] = queue.Queue(_CAPACITY)
        self._thread = threading.Thread(target=self._write_all, name='output', daemon=True)
        self._thread.start()

    def put(self, descriptor: int, text: str) -> None:
        """Queue a text for writing; drop it if the queue is full."""
        try:
            self._texts.put_nowait((descriptor, text))
        except queue.Full:
            self._dropped += 1

    def close(self) -> None:
        """Wait briefly until everything is written."""
        try:
            self._texts.put(None, timeout=_FLUSH_S)
        except queue.Full:
            return
        self._thread.join(_FLUSH_S)

    def _write_all(self) -> None:
        while (item := self._texts.get()) is not None:
            descriptor, text = item
            if self._dropped:
                text = f'({self._dropped} pieces of output were dropped)\n{text}'
                self._dropped = 0
            try:
                data = memoryview(text.encode(errors='replace'))
                while data:
                    data = data[os.write(descriptor, data) :]
            except OSError:
                self.broken = True


class QueuedStream(io.TextIOBase):
    """A text stream that writes through an OutputQueue."""

    encoding = 'utf-8'  # as `OutputQueue`; tqdm draws its bar accordingly

    def __init__(self, output: OutputQueue, stream: IO[str]) -> None:
        self._output = output
        self._descriptor = stream.fileno()

    def write(self, text: str) -> int:
        """Queue a text for writing."""
        self._output.put(self._descriptor, text)
        return len(text)

    def fileno(self) -> int:
        """Return the descriptor of the replaced stream."""
        return self._descriptor

    def isatty(self) -> bool:
        """Return whether the replaced stream is a terminal."""
        return os.isatty(self._descriptor)


@contextlib.contextmanager
def progress_output() -> Iterator[None]:
    """Hide a progress bar on stderr while other output, in whole lines, is written."""
    from tqdm.contrib import DummyTqdmFile  # not needed for help texts

    with (
        contextlib.redirect_stdout(cast(IO[str], DummyTqdmFile(sys.stdout))),
        contextlib.redirect_stderr(cast(IO[str], DummyTqdmFile(sys.stderr))),
    ):
        yield
