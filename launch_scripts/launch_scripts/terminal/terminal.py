"""Terminal: output line by line without ever blocking the launcher, and single keys."""

from __future__ import annotations

import contextlib
import io
import math
import os
import queue
import re
import select
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from io import TextIOBase
from typing import IO, cast

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
_UNFINISHED = re.compile(rb'\x1b(\[[0-?]*)?\Z').search


class Keyboard:
    """Reads single keys.

    Attributes:
        there: Whether there is a terminal; without one there are no keys.
        is_attended: Whether the terminal has answered since the last call of `pressed`, as far as
            it is asked.
        only_stops: Whether the keys of that call may stop robots but not start them.
    """

    def __init__(self, there: bool, only_stops: bool = False) -> None:
        self.there = there
        self.is_attended = True
        self.only_stops = only_stops

    def pressed(self) -> str:
        """Return the keys pressed since the last call; '' if none."""
        if not self.there:
            return ''
        keys = b''
        while select.select([sys.stdin], [], [], _SEQUENCE_S if _UNFINISHED(keys) else 0)[0]:
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
