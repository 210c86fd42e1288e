"""Terminal: output line by line, which never blocks the launcher, and keys, also over ssh."""

from __future__ import annotations

import math
import os
import queue
import re
import select
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from io import TextIOBase
from pathlib import Path
from typing import IO, cast

from setcmas_simu.errors import SetcmasError

try:
    import termios
except ImportError:  # Windows
    termios = None  # type: ignore[assignment]


@contextmanager
def single_key_terminal() -> Iterator[bool]:
    """Let keys arrive at once, without Enter; yield whether there is a terminal.

    Ctrl-C is still a signal. The terminal's settings are restored at the end.
    """
    stream = sys.__stdin__
    if termios is None or stream is None or stream.closed or not stream.isatty():
        yield False
        return
    import tty

    try:
        before = termios.tcgetattr(stream)
        tty.setcbreak(stream, termios.TCSANOW)
    except termios.error:  # the terminal has just been closed
        yield False
        return
    try:
        yield True
    finally:
        with suppress(termios.error):
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

    def __init__(self, prefix: str) -> None:
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


class QueuedStream(TextIOBase):
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


@contextmanager
def progress_output() -> Iterator[None]:
    """Hide a progress bar on stderr while other output, in whole lines, is written."""
    from tqdm.contrib import DummyTqdmFile  # not needed for help texts

    with (
        redirect_stdout(cast(IO[str], DummyTqdmFile(sys.stdout))),
        redirect_stderr(cast(IO[str], DummyTqdmFile(sys.stderr))),
    ):
        yield


ASK_EVERY_S = 0.1
"""Time between an answer and the next question, in s."""

LATEST_S = 0.4
"""Longest time for an answer, in s: later, the person's keys would be as late."""

_FIRST_WITHIN_S = 2.0
_CATCHES_UP_S = 0.5  # keys that were typed while nothing answered may arrive this long after
_QUESTION, _ANSWER = f'{ESC}[5n', f'{ESC}[0n'
_ANSWER_THEMSELVES = {
    'tmux: server': 'tmux',
    'screen': 'screen',
    'zellij': 'zellij',
    'mosh-server': 'mosh',
}
_OF_SSH = ('sshd', 'sshd-session')


@contextmanager
def open_operator_keyboard(holds_joystick: bool, emulated: bool) -> Iterator[Keyboard]:
    """Read single keys of a person who must be there; restore the terminal at the end.

    Args:
        holds_joystick: Whether robots move only while a button of a joystick at this computer is
            held: then keys over ssh stop robots and nothing else.
        emulated: Whether no real robots move: then only what the environment says of ssh counts.

    Raises:
        SetcmasError: Nobody would notice that the connection over ssh hangs.
    """
    is_remote = bool(os.environ.get('SSH_CONNECTION') or os.environ.get('SSH_TTY'))
    if not emulated:  # sudo and su clear the environment; the person at tmux may be anywhere
        is_remote |= any(name in _OF_SSH or name in _ANSWER_THEMSELVES for name in _parents())
    with single_key_terminal() as there:
        asks = there and is_remote and not holds_joystick
        yield RemoteKeyboard() if asks else Keyboard(there, only_stops=is_remote)


class RemoteKeyboard(Keyboard):
    """Reads keys over ssh, and asks the person's terminal several times a second for its status.

    Terminals answer Device Status Report, ESC [ 5 n, with ESC [ 0 n (ECMA-48, section 8.3.35): so
    does one at the other end of ssh, unless its window, its computer or the network hangs. Keys
    that may have been typed long ago only stop.
    """

    def __init__(self) -> None:
        """Ask for the first time.

        Raises:
            SetcmasError: The terminal does not answer, or another program answers for it.
        """
        super().__init__(there=True)
        self._asked, self._answered = -math.inf, -math.inf
        self._is_asking = False
        self._catches_up_until = math.inf
        # A program between the person and this process, such as tmux, answers by itself.
        if name := next(filter(None, map(_ANSWER_THEMSELVES.get, _parents())), ''):
            raise SetcmasError(
                f'{name} answers in place of your terminal, so robots would drive on when a '
                f'connection to it hangs: run setcmas outside of {name}, {_OTHER_WAY}'
            )
        deadline = time.monotonic() + _FIRST_WITHIN_S
        while self._answered < 0:
            self.pressed()
            if time.monotonic() > deadline:
                raise SetcmasError(
                    'the terminal at the other end of ssh does not answer, so robots would drive '
                    f'on when the connection hangs: use another terminal, {_OTHER_WAY}'
                )
            select.select([sys.stdin], [], [], ASK_EVERY_S)
        self._catches_up_until = -math.inf

    def pressed(self) -> str:
        """Return the keys pressed since the last call; '' if none. Ask again when due."""
        keys = super().pressed()
        now = time.monotonic()
        is_answer = self._is_asking and _ANSWER in keys
        took = now - self._asked
        if self._is_asking and took > LATEST_S:
            self._catches_up_until = now + _CATCHES_UP_S
        self.is_attended = is_answer and took <= LATEST_S
        self.only_stops = now < self._catches_up_until
        if is_answer:
            self._is_asking, self._answered = False, now
        if not self._is_asking and now - self._answered >= ASK_EVERY_S:
            self._ask(now)
        return keys.replace(_ANSWER, '')

    def _ask(self, now: float) -> None:
        # Never waits: the output of a connection that hangs is full sooner or later.
        with suppress(OSError):
            terminal = os.open(os.ttyname(sys.stdin.fileno()), os.O_WRONLY | os.O_NONBLOCK)
            try:
                os.write(terminal, _QUESTION.encode())
            finally:
                os.close(terminal)
            self._is_asking, self._asked = True, now


_OTHER_WAY = 'or add --hold and hold the button of a joystick that is wired to this computer'


def _parents() -> Iterator[str]:
    """Yield the names of the processes above this one, in small letters."""
    process = os.getppid()
    with suppress(OSError, ValueError, IndexError):
        while process > 1:
            name, rest = Path(f'/proc/{process}/stat').read_text().split('(', 1)[1].rsplit(')', 1)
            yield name.lower()
            process = int(rest.split()[1])
