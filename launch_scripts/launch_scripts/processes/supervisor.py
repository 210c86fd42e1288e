"""Supervisor of a command's processes: start, output, and complete clean-up."""

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
from setcmas_tools.offline.process_tree import adopt_orphans, children, end_orphans

# Ctrl-Z too: a suspended launcher would leave its robots unsupervised.
STOP_SIGNALS = known_signals('SIGINT', 'SIGTERM', 'SIGHUP', 'SIGTSTP')
_ENDS_S = 5.0
_ESCALATION = ((signal.SIGTERM, 3.0), (KILL, 5.0))
_TICK_S = 0.05  # delay until Esc is seen
_HANGS_S = 1.0  # a script call that runs longer keeps its process from ending
_HANGING_ENDS_S = 0.7
_ASIDE_ENDS_S = 5.0


class StoppedError(Exception):
    """The user stopped the command (Ctrl-C, SIGTERM, closed terminal)."""


class Supervisor:
    """Runs processes, shows their output, and cleans up after them.

    Use as a context manager: on exit it stops all processes.
    """

    def __init__(self, environment: dict[str, str], prefix: bool = False) -> None:
        """Prepare; with `prefix`, lines of output start with the name of their process."""
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
        """Take over the stop signals."""
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
        """Restore the previous signal handlers inside: the command works by itself."""
        own = _handled(self._previous_handlers)
        try:
            yield
        finally:
            _handled(own)

    def start(
        self, name: str, command: Sequence[str], needed: bool = True, listens: bool = False
    ) -> Child:
        """Start a process and show its output.

        Args:
            name: Name of the process in messages.
            command: Program and arguments.
            needed: Whether its end ends `run`.
            listens: Whether it reads messages of `Child.send`.
        """
        mistake = 'error' if self._prefix else f'setcmas {name}'
        child = Child(name, command, self._environment, needed, listens, mistake)
        self.children.append(child)
        self._watch(child.process.stdout, self._shows(child, self.stdout))
        self._watch(child.process.stderr, self._shows(child, self.stderr))
        self._watch(child.reports, _reports_of(child))
        return child

    def run(
        self,
        until: Callable[[], bool] = lambda: False,
        on_tick: Callable[[], None] = lambda: None,
    ) -> None:
        """Show output until a condition holds.

        Raises:
            ChildDiedError: A process ended unexpectedly.
            StoppedError: The user stopped the command.
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
                self.warn(f'{child.name} has ended; all else continues')
                self.stop(child)

    def _examine(self, child: Child) -> None:
        if child.disconnected:
            death = child.disconnection()
            child.signal_group(KILL)
            raise death
        if call := child.calls.silently_hanging():
            self.warn(
                f'{child.name} does not answer: {call} has not returned for {SILENT_S:g} s '
                '(a loop in C, or a suspended process); the robots of this process get no '
                'commands meanwhile; Ctrl-C stops'
            )
            child.on_hang()

    def run_aside(self, command: Sequence[str]) -> None:
        """Run a short process without output."""
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
        """Show output for a while, in any case."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            self._show_output(0.02)

    def warn(self, message: str) -> None:
        """Show a message of the command itself."""
        self.write(message, self.stderr)

    def stop(self, *children: Child) -> None:
        """Stop running processes one by one, gently at first."""
        for child in [child for child in children if child in self.children]:
            # Before a program has its own handler, Python answers SIGINT with a traceback.
            records = child.reported(Recording) is not None
            gently = ((signal.SIGINT, WRITES_S if records else _ENDS_S),) if child.spoke else ()
            for signum, wait_s in (*gently, *_ESCALATION):
                if not child.running():
                    break
                if signum == KILL:
                    self._warn_of_kill(child)
                child.signal_group(signum)
                self._await_end(child, wait_s)
            child.signal_group(KILL)  # left-over children of the process
            child.process.wait()
            child.calls.running()  # a call that a signal interrupted has failed, too
            if child.process.stdin:
                child.process.stdin.close()
            self._show_output(0)
            self.children.remove(child)

    def _await_end(self, child: Child, seconds: float) -> None:
        """Wait until a process ends; shorter if it hangs or the user insists."""
        begin = time.monotonic()
        signals = self._stop_signals
        while child.running() and self._stop_signals == signals:
            self._show_output(0.02)
            hangs = child.calls.running_s > _HANGS_S
            if time.monotonic() - begin > (_HANGING_ENDS_S if hangs else seconds):
                break

    def _warn_of_kill(self, child: Child) -> None:
        child.killed = True
        call = child.calls.running()
        during = f' in {call}' if call else ''
        self.warn(f'{child.name} did not end on request, and was killed{during}')

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
    """Set signal handlers; return the previous ones."""
    return {signum: signal.signal(signum, handler) for signum, handler in handlers.items()}


def _end(process: subprocess.Popen[bytes]) -> None:
    try:
        process.wait(_ASIDE_ENDS_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _reports_of(child: Child) -> Callable[[bytes], None]:
    decoder: LineDecoder[ChildReport] = LineDecoder(ChildReport)

    def take(data: bytes) -> None:
        for report in decoder.feed(data):
            child.take(report)
        if not data:
            child.note_end_of_reports()

    return take


def run_to_end(command: Sequence[str], environment: Mapping[str, str]) -> int:
    """Run a process in this terminal; return its exit status.

    Stop signals are passed on, so that the process ends cleanly.
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
    return status if status >= 0 else 128 - status  # as shells report it
