"""Output of processes in the terminal, line by line, never blocking the launcher."""

from __future__ import annotations

import contextlib
import io
import os
import queue
import sys
import threading
from collections.abc import Callable, Iterator
from io import TextIOBase
from typing import IO, Any, cast

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


_CAPACITY = 2000  # pieces of text
_LAST_WORDS_S = 1.0


class OutputQueue:
    """Writes texts to file descriptors, in order, from a thread of its own.

    Attributes:
        broken: Whether a reader has gone away (closed terminal or pipe).
    """

    def __init__(self) -> None:
        """Start the thread."""
        self.broken = False
        self._dropped = 0
        self._texts: queue.Queue[tuple[int, str] | None] = queue.Queue(_CAPACITY)
        self._thread = threading.Thread(target=self._write_all, name='output', daemon=True)
        self._thread.start()

    def put(self, descriptor: int, text: str) -> None:
        """Write a text soon; drop it if too much is waiting already."""
        try:
            self._texts.put_nowait((descriptor, text))
        except queue.Full:
            self._dropped += 1

    def close(self) -> None:
        """Wait, but not for long, until everything is written."""
        try:
            self._texts.put(None, timeout=_LAST_WORDS_S)
        except queue.Full:
            return
        self._thread.join(_LAST_WORDS_S)

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

    encoding = 'utf-8'  # that of `OutputQueue`: tqdm draws its bar accordingly

    def __init__(self, output: OutputQueue, stream: IO[str]) -> None:
        """Stand for a stream that has a file descriptor."""
        self._output = output
        self._descriptor = stream.fileno()

    def write(self, text: str) -> int:
        """Write a text soon."""
        self._output.put(self._descriptor, text)
        return len(text)

    def fileno(self) -> int:
        """Return the descriptor of the stream that this one stands for."""
        return self._descriptor

    def isatty(self) -> bool:
        """Return whether that stream is a terminal."""
        return os.isatty(self._descriptor)


class _ProgressOutput:
    def __init__(self, stream: IO[str], bar_stream: IO[str]) -> None:
        self._stream = stream
        self._bar_stream = bar_stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        from tqdm import tqdm  # help texts do without it

        with tqdm.external_write_mode(file=self._bar_stream):
            return self._stream.write(text)


@contextlib.contextmanager
def progress_output() -> Iterator[None]:
    """Take a bar on stderr away while something else is written, which must be whole lines."""
    bar = sys.stderr
    with (
        contextlib.redirect_stdout(cast(IO[str], _ProgressOutput(sys.stdout, bar))),
        contextlib.redirect_stderr(cast(IO[str], _ProgressOutput(sys.stderr, bar))),
    ):
        yield
