"""Processes of a command: each with its reports and its end, and the supervisor that cleans up."""

from __future__ import annotations

import ctypes
import os
import selectors
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from types import FrameType
from typing import IO, Any, TypeVar, cast

from launch_scripts.terminal import LineBuffer, OutputQueue, QueuedStream, Stream, write_line
from setcmas_simu.reports import VARIABLE as LAUNCHER_VARIABLE
from setcmas_simu.reports import (
    WRITES_S,
    Ended,
    Failed,
    LineDecoder,
    Mistake,
    ProcessMessage,
    Recording,
    Report,
    encode,
)
from setcmas_simu.script_calls import CurrentCall, Function, ScriptCall, ScriptFailure, shared_file

HANGS_S = 3.0
"""Time in s after which a script call hangs; the process itself reports it sooner, if it can."""

_PR_SET_PDEATHSIG = 1
_libc = ctypes.CDLL(None) if sys.platform == 'linux' else None
_ENDS_WITHIN_S = 1.0  # after it has closed the pipe of its reports

AnyReport = TypeVar('AnyReport', bound=ProcessMessage)


class ChildDiedError(Exception):
    """A process ended unexpectedly; `exit_status` is for the command."""

    def __init__(self, message: str, exit_status: int = 1) -> None:
        super().__init__(message)
        self.exit_status = exit_status


class Child:
    """A running process in its own process group.

    Attributes:
        shown: Whether its output is shown.
        needed: Whether the other processes need it.
        reports: Pipe of its reports.
        call: The script call that it is in.
        failures: Periods of failed calls, as it reports at its end.
        killed: Whether it had to be killed.
    """

    def __init__(
        self,
        name: str,
        command: Sequence[str],
        environment: dict[str, str],
        needed: bool,
        listens: bool,
        mistake: str,
        kinds: Any,
        on_report: Callable[[ProcessMessage], object],
    ) -> None:
        """Start the process; its error messages begin with `mistake`.

        `on_report` is called with each of its reports, which have one of the types `kinds`.
        """
        self.name = name
        self.needed = needed
        self.shown = True
        self.killed = False
        self.failures: tuple[ScriptFailure, ...] = ()
        self._on_report = on_report
        self._decoder: LineDecoder[ProcessMessage] = LineDecoder(kinds)
        self._reported: dict[type[ProcessMessage], ProcessMessage] = {}
        self._failed: dict[ScriptCall, None] = {}
        self._disconnected: str | None = None
        reports, pipe = os.pipe()
        self.reports = os.fdopen(reports, 'rb', buffering=0)
        memory = shared_file()
        self.call = CurrentCall.shared(memory)
        self.process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE if listens else subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=environment | {LAUNCHER_VARIABLE: f'{pipe} {memory} {mistake}'},
            pass_fds=(pipe, memory),
            preexec_fn=_prepare,
        )
        os.close(pipe)
        os.close(memory)

    def running(self) -> bool:
        """Return whether the process is running."""
        return self.process.poll() is None

    def send(self, message: ProcessMessage) -> None:
        """Send a message to the standard input of the process, without waiting."""
        assert self.process.stdin is not None
        os.set_blocking(self.process.stdin.fileno(), False)
        with suppress(BlockingIOError, BrokenPipeError):  # it hangs or has ended
            os.write(self.process.stdin.fileno(), encode(message))

    def signal_group(self, signum: int) -> None:
        """Send a signal to the process and its children."""
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(self.process.pid, signum)

    def take_reports(self, data: bytes) -> None:
        """Take what has come through the pipe of reports; nothing if it is closed."""
        for report in self._decoder.feed(data):
            self._reported[type(report)] = report
            if isinstance(report, Failed):
                self._failed[report.call] = None
            elif isinstance(report, Ended):
                self._failed |= dict.fromkeys(report.failed)
                self.failures = report.failures
            self._on_report(report)
        if not data:
            self._end_if_disconnected()

    def _end_if_disconnected(self) -> None:
        """Kill the process if it goes on although a script has closed its pipe of reports."""
        place = self._place()
        try:
            self.process.wait(_ENDS_WITHIN_S)
        except subprocess.TimeoutExpired:
            self._disconnected = place
            self.signal_group(signal.SIGKILL)
            self.process.wait()

    def reported(self, kind: type[AnyReport]) -> AnyReport | None:
        """Return the newest report of a kind; None if there was none."""
        return cast('AnyReport | None', self._reported.get(kind))

    @property
    def running_s(self) -> float:
        """How long a script call has been running, in s; 0 between calls."""
        return self.call.running_s(time.monotonic())

    def silent_call(self) -> ScriptCall | None:
        """Return a script call that hangs without a word of the process about it; each once."""
        if self.call.is_reported or self.running_s <= HANGS_S:
            return None
        self.call.is_reported = True
        return self.running_call()

    def running_call(self) -> ScriptCall | None:
        """Return the running script call, and count it as failed; None between calls."""
        call = self.call.running()
        if call and call.function is not Function.LOADING:
            self._failed[call] = None
        return call

    @property
    def failed(self) -> tuple[ScriptCall, ...]:
        """Script calls that failed, hung, or were running when the process was killed or died."""
        return tuple(self._failed)

    @property
    def missing(self) -> str:
        """Why control laws are not called yet."""
        call = self.call.running()
        return f'{call} has not returned' if call else 'the controllers have not called their laws'

    @property
    def exit_status(self) -> int:
        """Exit status of a process that was asked to stop: 0 only if nothing went wrong."""
        status = self.process.returncode
        if self.killed or (status <= 0 and self.failed):
            return 1
        if status == -signal.SIGTERM:
            return 0  # stopped before it could handle signals
        return status if status >= 0 else 128 - status  # as shells report it

    def unexpected_end(self) -> ChildDiedError:
        """Return why the process ended, as an exception."""
        status = self.process.returncode
        if status == 2 and self.reported(Mistake):
            return ChildDiedError('', 2)
        place = self._place()
        if self._disconnected is not None:
            reason, place, status = 'has lost its file descriptors', self._disconnected, 1
        elif status < 0:
            reason = f'was killed by {signal.Signals(-status).name}'
            reason += ' (out of memory?)' if -status == signal.SIGKILL else ''
            status = 128 - status  # as shells report it
        else:
            reason = f'ended unexpectedly with exit status {status}'
        message = f'{self.name} (process {self.process.pid}) {reason}{place}'
        return ChildDiedError(message, 1 if self.running_call() else status or 1)

    def _place(self) -> str:
        """Return in or after which script call the process is; '' if there was none."""
        if call := self.running_call():
            return f' in {call}'
        return f' after {call}' if (call := self.call.last()) else ''


def _prepare() -> None:
    """Give a child that begins a process group of its own, and let it end with its parent."""
    os.setpgid(0, 0)
    if _libc:
        _libc.prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)


# Ctrl-Z too: a suspended launcher would leave its robots unsupervised.
_STOPS = ('SIGINT', 'SIGTERM', 'SIGHUP', 'SIGTSTP')
STOP_SIGNALS = tuple(signal.Signals[name] for name in _STOPS if hasattr(signal, name))
_ENDS_S = 5.0
_TICK_S = 0.05  # longest delay before a key press is noticed
_LATE_S = 1.0  # a longer script call keeps its process from ending
_LATE_ENDS_S = 1.5


class StoppedError(Exception):
    """The user stopped the command (Ctrl-C, SIGTERM, closed terminal)."""


class Supervisor:
    """Runs processes, shows their output, and cleans up after them.

    Use as a context manager: on exit it stops all processes.
    """

    def __init__(self, environment: dict[str, str], prefix: bool = False) -> None:
        """Prepare; with `prefix`, lines of output start with the name of their process."""
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
        self._previous_handlers = _handled(dict.fromkeys(STOP_SIGNALS, self._on_signal))
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.stop(*reversed(self.children))
        for key in list(self._selector.get_map().values()):
            cast(IO[bytes], key.fileobj).close()
        self._selector.close()
        self._output.close()
        _handled(self._previous_handlers)

    @contextmanager
    def signals_handed_back(self) -> Iterator[None]:
        """Restore the previous signal handlers inside, for work of the command itself."""
        own = _handled(self._previous_handlers)
        try:
            yield
        finally:
            _handled(own)

    def start(
        self,
        name: str,
        command: Sequence[str],
        needed: bool = True,
        listens: bool = False,
        reports: Any = Report,
        on_report: Callable[[ProcessMessage], object] = bool,
    ) -> Child:
        """Start a process and show its output.

        Args:
            name: Name of the process in messages.
            command: Program and arguments.
            needed: Whether `run` ends when it ends.
            listens: Whether it reads what `Child.send` sends.
            reports: The kinds of its reports.
            on_report: Called with each of them.
        """
        mistake = 'error' if self._prefix else f'setcmas {name}'
        environment = self._environment
        child = Child(name, command, environment, needed, listens, mistake, reports, on_report)
        self.children.append(child)
        self._watch(child.process.stdout, self._printer(child, self.stdout))
        self._watch(child.process.stderr, self._printer(child, self.stderr))
        self._watch(child.reports, child.take_reports)
        return child

    def run(
        self, until: Callable[[], bool] = lambda: False, on_tick: Callable[[], None] = lambda: None
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
            for child in list(self.children):
                if not child.running():
                    self._show_output(0)
                    if child.needed:
                        raise child.unexpected_end()
                    self.warn(f'{child.name} has ended; everything else continues')
                    self.stop(child)
                elif call := child.silent_call():
                    self.warn(
                        f'{child.name} does not answer: {call} has not returned for {HANGS_S:g} s '
                        '(a loop in C, or a suspended process); its robots get no commands until '
                        'it returns; Ctrl-C stops'
                    )

    def run_to_end(
        self, child: Child, on_tick: Callable[[], None] = lambda: None, may_end: bool = True
    ) -> int:
        """Show output until a process ends, or the user stops the command; return the status."""
        try:
            self.run(on_tick=on_tick)
        except StoppedError:
            self.stop(child)
        except ChildDiedError as death:
            if not may_end or child.process.returncode < 0:
                return self.report_death(death)
        return child.exit_status

    def wait(self, seconds: float) -> None:
        """Show output for some seconds, whatever happens."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            self._show_output(0.02)

    def warn(self, message: str) -> None:
        """Show a message of the command itself."""
        self.write(message, self.stderr)

    def report_death(self, death: ChildDiedError, verb: str = '') -> int:
        """Show why a process died, unless it has said so; return the command's exit status."""
        if reason := str(death):
            self.warn(f'{f"setcmas {verb}".rstrip()}: {reason}')
        return death.exit_status

    def stop(self, *children: Child) -> None:
        """Stop processes one after the other: by SIGTERM, then by SIGKILL."""
        for child in [child for child in children if child in self.children]:
            if child.running():  # not SIGINT: a Python that starts answers with a traceback
                child.signal_group(signal.SIGTERM)
                self._await_end(child, WRITES_S if child.reported(Recording) else _ENDS_S)
            call = child.running_call()  # which an end has interrupted, so it has failed
            if child.running():
                child.killed = True
                during = f' in {call}' if call else ''
                self.warn(f'{child.name} did not stop when asked, so it was killed{during}')
            child.signal_group(signal.SIGKILL)  # also what the process has started
            child.process.wait()
            if child.process.stdin:
                child.process.stdin.close()
            self._show_output(0)
            self.children.remove(child)

    def _await_end(self, child: Child, seconds: float) -> None:
        """Wait until a process ends; less if it hangs or the user presses Ctrl-C twice."""
        begin, signals = time.monotonic(), self._stop_signals
        while child.running() and self._stop_signals < signals + 2:
            self._show_output(0.02)
            is_late = child.running_s > _LATE_S
            if time.monotonic() - begin > (_LATE_ENDS_S if is_late else seconds):
                break

    def _watch(self, pipe: IO[bytes] | None, take: Callable[[bytes], None]) -> None:
        assert pipe is not None
        os.set_blocking(pipe.fileno(), False)
        self._selector.register(pipe, selectors.EVENT_READ, take)

    def _printer(self, child: Child, stream: Stream) -> Callable[[bytes], None]:
        lines = LineBuffer(f'[{child.name}] ' if self._prefix else '', stream)

        def show(data: bytes) -> None:
            for line in lines.feed(data):
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
