"""Supervisor of the processes of a command: start, output, and an end without leftovers."""

from __future__ import annotations

import os
import selectors
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from types import FrameType
from typing import IO, Any, cast

from launch_scripts.processes.child_process import (
    KILL,
    SILENT_S,
    Child,
    ChildReport,
    known_signals,
    prepare_child,
)
from launch_scripts.terminal.terminal_output import (
    LineBuffer,
    OutputQueue,
    QueuedStream,
    Stream,
    write_line,
)
from setcmas_simu.reports.reports import WRITES_S, LineDecoder, Recording
from setcmas_tools.process_tree import adopt_orphans, children, end_orphans

# Ctrl-Z too: a launcher that is asleep would leave its robots without supervision.
STOP_SIGNALS = known_signals('SIGINT', 'SIGTERM', 'SIGHUP', 'SIGTSTP')
_ENDS_S = 5.0
_ESCALATION = ((signal.SIGTERM, 3.0), (KILL, 5.0))
_TICK_S = 0.05  # Esc is seen after it
_HANGS_S = 1.0  # a call of a script that runs for longer keeps its process from ending
_HANGING_ENDS_S = 0.7
_ASIDE_ENDS_S = 5.0


class StoppedError(Exception):
    """The user asked the command to end (Ctrl-C, SIGTERM, closed terminal)."""


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
        self._aside: list[subprocess.Popen[bytes]] = []
        self.write: Callable[[str, Stream], None] = write_line
        self._output = OutputQueue()
        self.stdout = QueuedStream(self._output, sys.stdout)
        self.stderr = QueuedStream(self._output, sys.stderr)
        self._environment = environment
        self._prefix = prefix
        self._selector = selectors.DefaultSelector()
        self._stop_signals = 0
        self._strangers: set[int] = set()
        self._previous_handlers: dict[signal.Signals, Any] = {}

    def __enter__(self) -> Supervisor:
        """Take over the signals that ask to stop."""
        self._previous_handlers = _handled(dict.fromkeys(STOP_SIGNALS, self._on_signal))
        adopt_orphans()
        self._strangers = children()
        return self

    def __exit__(self, *exc_info: object) -> None:
        """Stop all processes."""
        self.stop(*reversed(self.children))
        for process in self._aside:
            _end(process)
        end_orphans(self._strangers)
        for key in list(self._selector.get_map().values()):
            cast(IO[bytes], key.fileobj).close()
        self._selector.close()
        self._output.close()
        _handled(self._previous_handlers)

    @contextmanager
    def signals_handed_back(self) -> Iterator[None]:
        """Let signals do meanwhile what they did before: the command works by itself."""
        own = _handled(self._previous_handlers)
        try:
            yield
        finally:
            _handled(own)

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
        mistake = 'error' if self._prefix else f'setcmas {name}'
        child = Child(name, command, self._environment, needed, listens, mistake)
        self.children.append(child)
        self._watch(child.process.stdout, self._shows(child, self.stdout))
        self._watch(child.process.stderr, self._shows(child, self.stderr))
        self._watch(child.reports, _hears(child))
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
            for child in self.children:
                self._examine(child)
            for child in [child for child in self.children if not child.running()]:
                self._show_output(0)
                if child.needed:
                    raise child.obituary()
                self.warn(f'{child.name} has ended; all else goes on')
                self.stop(child)

    def _examine(self, child: Child) -> None:
        if child.disconnected:
            death = child.disconnection()
            child.signal_group(KILL)
            raise death
        if call := child.calls.silently_hanging():
            self.warn(
                f'{child.name} does not answer: {call} has not returned for {SILENT_S:g} s '
                '(a loop in C, or a stopped process); no robot of this process is commanded '
                'meanwhile; Ctrl-C stops'
            )
            child.on_hang()

    def run_aside(self, command: Sequence[str]) -> None:
        """Run a process that ends by itself, soon, and without a word."""
        self._aside.append(
            subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                env=self._environment,
                preexec_fn=prepare_child(),
            )
        )

    def wait(self, seconds: float) -> None:
        """Show output for a while, whatever happens."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            self._show_output(0.02)

    def warn(self, message: str) -> None:
        """Show a message of the command itself."""
        self.write(message, self.stderr)

    def stop(self, *children: Child) -> None:
        """Stop processes one after the other, gently at first, unless they are stopped already."""
        for child in [child for child in children if child in self.children]:
            # Python answers SIGINT with a traceback until a program has its own handler.
            records = child.heard(Recording) is not None
            gently = ((signal.SIGINT, WRITES_S if records else _ENDS_S),) if child.spoke else ()
            for signum, wait_s in (*gently, *_ESCALATION):
                if not child.running():
                    break
                if signum == KILL:
                    self._tell_of_kill(child)
                child.signal_group(signum)
                self._await_end(child, wait_s)
            child.signal_group(KILL)  # what the process itself left behind
            child.process.wait()
            child.calls.running()  # a call that a signal has cut off has failed, too
            if child.process.stdin:
                child.process.stdin.close()
            self._show_output(0)
            self.children.remove(child)

    def _await_end(self, child: Child, seconds: float) -> None:
        """Wait until a process ends; not as long for one that hangs, or if the user insists."""
        begin = time.monotonic()
        signals = self._stop_signals
        while child.running() and self._stop_signals == signals:
            self._show_output(0.02)
            hangs = child.calls.running_s > _HANGS_S
            if time.monotonic() - begin > (_HANGING_ENDS_S if hangs else seconds):
                break

    def _tell_of_kill(self, child: Child) -> None:
        child.killed = True
        call = child.calls.running()
        during = f' in {call}' if call else ''
        self.warn(f'{child.name} did not end when asked to, and is killed{during}')

    def _watch(self, pipe: IO[bytes] | None, take: Callable[[bytes], None]) -> None:
        assert pipe is not None
        os.set_blocking(pipe.fileno(), False)
        self._selector.register(pipe, selectors.EVENT_READ, take)

    def _shows(self, child: Child, stream: Stream) -> Callable[[bytes], None]:
        lines = LineBuffer(f'[{child.name}] ' if self._prefix else '', stream)

        def show(data: bytes) -> None:
            for line in lines.feed(data):
                child.spoke = True
                if child.shown:
                    self.write(line, stream)

        return show

    def _show_output(self, timeout_s: float) -> None:
        for key, _ in self._selector.select(timeout_s):
            try:
                data = os.read(key.fd, 65536)
            except BlockingIOError:
                continue
            key.data(data)
            if not data:
                self._selector.unregister(key.fileobj)
                cast(IO[bytes], key.fileobj).close()

    def _on_signal(self, _signum: int, _frame: FrameType | None) -> None:
        self._stop_signals += 1


def _handled(handlers: Mapping[signal.Signals, Any]) -> dict[signal.Signals, Any]:
    """Set handlers of signals; returns those that were there before."""
    return {signum: signal.signal(signum, handler) for signum, handler in handlers.items()}


def _end(process: subprocess.Popen[bytes]) -> None:
    try:
        process.wait(_ASIDE_ENDS_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _hears(child: Child) -> Callable[[bytes], None]:
    decoder: LineDecoder[ChildReport] = LineDecoder(ChildReport)

    def hear(data: bytes) -> None:
        for report in decoder.feed(data):
            child.hear(report)
        if not data:
            child.note_end_of_reports()

    return hear


def run_to_end(command: Sequence[str], environment: Mapping[str, str]) -> int:
    """Run a process with this one's terminal; returns its exit status.

    Signals that ask to stop are handed on, so that the process ends in its own order.
    """
    process = subprocess.Popen(command, env=environment)

    def hand_on(signum: int, _frame: FrameType | None) -> None:
        process.send_signal(signum)

    previous = {signum: signal.signal(signum, hand_on) for signum in STOP_SIGNALS}
    try:
        status = process.wait()
    finally:
        for signum, handler in previous.items():
            signal.signal(signum, handler)
    return status if status >= 0 else 128 - status  # as shells tell it
