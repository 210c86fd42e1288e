"""Starts, watches and stops the processes of a command."""

from __future__ import annotations

import ctypes
import os
import selectors
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from types import FrameType
from typing import Any

from launch_scripts.output_lines import TOLD, LineBuffer, Stream, write_line
from launch_scripts.output_queue import OutputQueue, QueuedStream


def _known_signals(*names: str) -> tuple[signal.Signals, ...]:
    """Return the signals of these names that this system has: Windows lacks some."""
    return tuple(signal.Signals[name] for name in names if name in signal.Signals.__members__)


# Ctrl-Z too: a launcher that is asleep would leave its robots without supervision.
STOP_SIGNALS = _known_signals('SIGINT', 'SIGTERM', 'SIGHUP', 'SIGTSTP')
_KILL = _known_signals('SIGKILL', 'SIGTERM')[0]
_ESCALATION = ((signal.SIGINT, 5.0), (signal.SIGTERM, 3.0), (_KILL, 5.0))
_TICK_S = 0.1
_PR_SET_PDEATHSIG = 1


class ChildDiedError(Exception):
    """A process ended that nobody had asked to end.

    Attributes:
        exit_status: What the command should exit with.
        child: The process.
    """

    def __init__(self, message: str, exit_status: int, child: Child) -> None:
        """Store the message, the exit status and the process."""
        super().__init__(message)
        self.exit_status = exit_status
        self.child = child


class StoppedError(Exception):
    """The user asked the command to end (Ctrl-C, SIGTERM, closed terminal)."""


class Child:
    """A running process in a process group of its own.

    Attributes:
        spoke: Whether it has written anything; before, it may not know our signals yet.
        told: Whether it has told the user about a mistake, in its own words.
        needed: Whether the others cannot go on without it.
    """

    def __init__(
        self,
        name: str,
        command: Sequence[str],
        environment: dict[str, str],
        needed: bool,
        listens: bool,
    ) -> None:
        """Start the process; arguments as for `Supervisor.start`."""
        self.name = name
        self.needed = needed
        self.spoke = self.told = False
        self.process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE if listens else subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=environment,
            preexec_fn=_prepare_child(),
        )

    def running(self) -> bool:
        """Return whether the process has not ended yet."""
        return self.process.poll() is None

    def tell(self, line: str) -> None:
        """Write a line to the standard input of a process that listens; never waits."""
        assert self.process.stdin is not None
        os.set_blocking(self.process.stdin.fileno(), False)
        with suppress(BlockingIOError, BrokenPipeError):  # it hangs, or has ended
            os.write(self.process.stdin.fileno(), f'{line}\n'.encode())

    def signal_group(self, signum: int) -> None:
        """Send a signal to the process and whatever it started."""
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(self.process.pid, signum)

    def obituary(self) -> ChildDiedError:
        """Return why the process ended, as an exception."""
        status = self.process.returncode
        if status == 2 and self.told:
            return ChildDiedError('', 2, self)
        if status < 0:
            reason = f'was killed by {signal.Signals(-status).name}'
            reason += ' (out of memory?)' if -status == _KILL else ''
            status = 128 - status  # as shells tell it
        else:
            reason = f'ended by itself with exit status {status}'
        message = f'{self.name} (process {self.process.pid}) {reason}'
        return ChildDiedError(message, status or 1, self)


class Supervisor:
    """Runs processes side by side, shows their output, and leaves none behind.

    Use as a context manager: leaving it stops what still runs.
    """

    def __init__(self, environment: dict[str, str], prefix: bool = False) -> None:
        """Prepare.

        Args:
            environment: The environment of all processes.
            prefix: Whether lines of output begin with the name of their process.
        """
        self.children: list[Child] = []
        self.write: Callable[[str, Stream], None] = write_line
        self._output = OutputQueue()
        self.stdout = QueuedStream(self._output, sys.stdout)
        self.stderr = QueuedStream(self._output, sys.stderr)
        self._environment = environment
        self._prefix = prefix
        self._selector = selectors.DefaultSelector()
        self._stop_signals = 0
        self._previous_handlers: dict[signal.Signals, Any] = {}

    def __enter__(self) -> Supervisor:
        """Take over the signals that ask to stop."""
        for signum in STOP_SIGNALS:
            self._previous_handlers[signum] = signal.signal(signum, self._on_signal)
        return self

    def __exit__(self, *exc_info: object) -> None:
        """Stop all processes."""
        self.stop(*reversed(self.children))
        for key in list(self._selector.get_map().values()):
            key.fileobj.close()  # type: ignore[union-attr]
        self._selector.close()
        self._output.close()
        for signum, handler in self._previous_handlers.items():
            signal.signal(signum, handler)

    def start(
        self, name: str, command: Sequence[str], needed: bool = True, listens: bool = False
    ) -> Child:
        """Start a process and show its output from now on.

        Args:
            name: What the user calls it.
            command: Program and arguments.
            needed: Whether `run` ends when it does; windows can be closed while robots run.
            listens: Whether it reads what `Child.tell` writes.
        """
        child = Child(name, command, self._environment, needed, listens)
        self.children.append(child)
        prefix = f'[{name}] ' if self._prefix else ''
        for pipe, stream in (
            (child.process.stdout, self.stdout),
            (child.process.stderr, self.stderr),
        ):
            assert pipe is not None
            os.set_blocking(pipe.fileno(), False)
            lines = LineBuffer(prefix, stream)
            self._selector.register(pipe, selectors.EVENT_READ, (child, lines))
        return child

    def run(
        self,
        until: Callable[[], bool] = lambda: False,
        on_tick: Callable[[], None] = lambda: None,
    ) -> None:
        """Show output until a condition holds.

        Raises:
            ChildDiedError: A process ended by itself.
            StoppedError: The user asked the command to end.
        """
        while not until():
            self._show_output(_TICK_S)
            on_tick()
            if self._stop_signals or self._output.broken:
                raise StoppedError
            for child in [child for child in self.children if not child.running()]:
                self._show_output(0)
                if child.needed:
                    raise child.obituary()
                self.say(f'{child.name} has ended; the robots go on')
                self.stop(child)

    def wait(self, seconds: float) -> None:
        """Show output for a while, whatever happens."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            self._show_output(0.02)

    def say(self, message: str) -> None:
        """Show a message of the command itself."""
        self.write(message, self.stderr)

    def stop(self, *children: Child) -> None:
        """Stop processes one after the other, gently at first."""
        for child in children:
            # Python answers SIGINT with a traceback until a program has its own handler.
            for signum, wait_s in _ESCALATION if child.spoke else _ESCALATION[1:]:
                if not child.running():
                    break
                child.signal_group(signum)
                deadline = time.monotonic() + wait_s
                signals = self._stop_signals  # an impatient user may press Ctrl-C again
                while (
                    child.running()
                    and time.monotonic() < deadline
                    and self._stop_signals == signals
                ):
                    self._show_output(0.02)
            child.signal_group(_KILL)  # what the process itself left behind
            child.process.wait()
            if child.process.stdin:
                child.process.stdin.close()
            self._show_output(0)
            if child in self.children:
                self.children.remove(child)

    def _show_output(self, timeout_s: float) -> None:
        for key, _ in self._selector.select(timeout_s):
            pipe, (child, lines) = key.fileobj, key.data
            try:
                data = os.read(key.fd, 65536)
            except BlockingIOError:
                continue
            for line in lines.feed(data):
                child.spoke = True
                child.told = child.told or TOLD in line
                self.write(line, lines.stream)
            if not data:
                self._selector.unregister(pipe)
                pipe.close()  # type: ignore[union-attr]

    def _on_signal(self, _signum: int, _frame: FrameType | None) -> None:
        self._stop_signals += 1


def _prepare_child() -> Callable[[], None]:
    """Return what a child does first: its own process group, and an end with its parent."""
    parent = os.getpid()
    libc = ctypes.CDLL(None) if sys.platform == 'linux' else None

    def prepare() -> None:
        os.setpgid(0, 0)
        if libc is not None:
            libc.prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
            if os.getppid() != parent:
                os._exit(1)

    return prepare
