"""A process that a command has started: its script calls, its end and the reason."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import TypeVar, cast

from setcmas_simu.reports.current_call import CurrentCall, shared_file
from setcmas_simu.reports.reports import VARIABLE as LAUNCHER_VARIABLE
from setcmas_simu.reports.reports import Ended, Failed, Message, Mistake, Stuck, encode
from setcmas_simu.reports.script_calls import Function, ScriptCall, ScriptFailure

SILENT_S = 3.0
"""Time in s after which a call hangs if the process reports nothing: a loop in C cannot."""


class ScriptCalls:
    """Script calls of one process, by its reports and memory that it shares.

    Attributes:
        failures: Periods of failed calls, as the process reports at its end.
    """

    def __init__(self, memory: int) -> None:
        self._current = CurrentCall.shared(memory)
        self._failed: dict[ScriptCall, None] = {}
        self._reported_since = 0.0
        self.failures: tuple[ScriptFailure, ...] = ()

    @property
    def failed(self) -> tuple[ScriptCall, ...]:
        """Calls that failed, hung, or were running when the process was killed or died."""
        return tuple(self._failed)

    def take(self, report: Message) -> None:
        """Take a report of the process."""
        if isinstance(report, Failed):
            self._failed[report.call] = None
        elif isinstance(report, Ended):
            self._failed |= dict.fromkeys(report.failed)
            self.failures = report.failures
        elif isinstance(report, Stuck):
            self._reported_since = self._current.since
            self.note(report.call)

    def silently_hanging(self) -> ScriptCall | None:
        """Return a call that hangs although the process does not report it; each call once."""
        if self.running_s <= SILENT_S or self._current.since == self._reported_since:
            return None
        self._reported_since = self._current.since
        return self.running()

    def running(self) -> ScriptCall | None:
        """Return the running call, and count it as failed; None between calls."""
        call = self._current.running()
        if call:
            self.note(call)
        return call

    def described(self) -> str:
        """Return in or after which call the process ended; '' if there was none."""
        if call := self.running():
            return f' in {call}'
        return f' after {self.last()}' if self.last() else ''

    @property
    def missing(self) -> str:
        """Why control laws are not called yet."""
        call = self.running()
        return f'{call} has not returned' if call else 'the controllers have not called their laws'

    @property
    def running_s(self) -> float:
        """How long a call has been running, in s; 0 between calls."""
        return self._current.running_s(time.monotonic())

    def last(self) -> ScriptCall | None:
        """Return the last call that began; None if there was none."""
        return self._current.last()

    def note(self, call: ScriptCall) -> None:
        """Count a call as failed, unless its script is still loading."""
        if call.function is not Function.LOADING:
            self._failed[call] = None


AnyReport = TypeVar('AnyReport', bound=Message)


def known_signals(*names: str) -> tuple[signal.Signals, ...]:
    """Return the named signals; the system may lack some (Windows does)."""
    return tuple(signal.Signals[name] for name in names if name in signal.Signals.__members__)


KILL = known_signals('SIGKILL', 'SIGTERM')[0]
"""The signal that no process survives."""

_PR_SET_PDEATHSIG = 1
_ENDS_WITHIN_S = 1.0  # after it has closed the pipe of its reports


class ChildDiedError(Exception):
    """A process ended unexpectedly; `exit_status` is for the command."""

    def __init__(self, message: str, exit_status: int) -> None:
        super().__init__(message, exit_status)
        self.exit_status = exit_status

    def __str__(self) -> str:
        return str(self.args[0])


class Child:
    """A running process in its own process group.

    Attributes:
        command: Program and arguments.
        has_output: Whether it has written anything; before, it may not handle signals yet.
        shown: Whether its output is shown.
        needed: Whether the other processes need it.
        reports: Pipe of its reports.
        on_hang: Called when a script call does not return.
        killed: Whether it had to be killed.
        on_report: Called with its reports.
    """

    def __init__(
        self,
        name: str,
        command: Sequence[str],
        environment: dict[str, str],
        needed: bool,
        listens: bool,
        mistake: str,
    ) -> None:
        """Start the process; its error messages begin with `mistake`."""
        self.name = name
        self.command = command
        self.needed = needed
        self.has_output = False
        self.shown = True
        self.on_report: Callable[[Message], None] = lambda _: None
        self._reported: dict[type[Message], Message] = {}
        reports, pipe = os.pipe()
        self.reports = os.fdopen(reports, 'rb', buffering=0)
        memory = shared_file()
        self.calls = ScriptCalls(memory)
        self.on_hang: Callable[[], None] = lambda: None
        self.killed = False
        self._disconnected: float | None = None
        self._disconnected_in: ScriptCall | None = None
        self.process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE if listens else subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=environment | {LAUNCHER_VARIABLE: f'{pipe} {memory} {mistake}'},
            pass_fds=(pipe, memory),
            preexec_fn=prepare_child(),
        )
        os.close(pipe)
        os.close(memory)

    def running(self) -> bool:
        """Return whether the process is running."""
        return self.process.poll() is None

    def send(self, message: Message) -> None:
        """Send a message to the standard input of the process, without waiting."""
        assert self.process.stdin is not None
        os.set_blocking(self.process.stdin.fileno(), False)
        with suppress(BlockingIOError, BrokenPipeError):  # it hangs or has ended
            os.write(self.process.stdin.fileno(), encode(message))

    def take(self, report: Message) -> None:
        """Take a report of the process."""
        self.has_output = True
        self._reported[type(report)] = report
        self.calls.take(report)
        self.on_report(report)
        if isinstance(report, Stuck):
            self.on_hang()

    def note_end_of_reports(self) -> None:
        """Note that its report pipe is closed: it is ending, or a script has closed the pipe."""
        self._disconnected = time.monotonic()
        self._disconnected_in = self.calls.last()

    @property
    def disconnected(self) -> bool:
        """Whether it is still running although its report pipe has been closed for some time."""
        since = self._disconnected
        return since is not None and self.running() and time.monotonic() - since > _ENDS_WITHIN_S

    @property
    def exit_status(self) -> int:
        """Exit status of a process that was asked to stop: 0 only if nothing went wrong."""
        status = self.process.returncode
        if self.killed or (status <= 0 and self.calls.failed):
            return 1
        if status == -signal.SIGTERM and not self.has_output:
            return 0  # stopped before it could handle signals
        return status if status >= 0 else 128 - status  # as shells report it

    def reported(self, kind: type[AnyReport]) -> AnyReport | None:
        """Return the newest report of a kind; None if there was none."""
        return cast('AnyReport | None', self._reported.get(kind))

    def signal_group(self, signum: int) -> None:
        """Send a signal to the process and its children."""
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(self.process.pid, signum)

    def unexpected_end(self) -> ChildDiedError:
        """Return why the process ended, as an exception."""
        status = self.process.returncode
        if status == 2 and self.reported(Mistake):
            return ChildDiedError('', 2)
        if status < 0:
            reason = f'was killed by {signal.Signals(-status).name}'
            reason += ' (out of memory?)' if -status == KILL else ''
            status = 128 - status  # as shells report it
        else:
            reason = f'ended unexpectedly with exit status {status}'
        message = f'{self.name} (process {self.process.pid}) {reason}{self.calls.described()}'
        return ChildDiedError(message, 1 if self.calls.running() else status or 1)

    def disconnection(self) -> ChildDiedError:
        """Return an exception for a process whose report pipe a script has closed."""
        call = self._disconnected_in
        if call:
            self.calls.note(call)
        by = f'closed in {call}' if call else 'the process closed them'
        message = f'{self.name} (process {self.process.pid}) has lost its file descriptors: {by}'
        return ChildDiedError(message, 1)


def prepare_child() -> Callable[[], None]:
    """Return a function for the child to call first: own process group, end with the parent."""
    parent = os.getpid()
    libc = ctypes.CDLL(None) if sys.platform == 'linux' else None

    def prepare() -> None:
        os.setpgid(0, 0)
        if libc is not None:
            libc.prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
            if os.getppid() != parent:
                os._exit(1)

    return prepare
