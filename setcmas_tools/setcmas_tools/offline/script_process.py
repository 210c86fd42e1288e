"""Process of a function that runs scripts: one that hangs or dies ends it, not this process."""

from __future__ import annotations

import faulthandler
import io
import multiprocessing
import os
import re
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from math import inf
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np

from setcmas_ctrl.laws.call_watch import STUCK_S
from setcmas_ctrl.laws.script_errors import described_place, quoted_line, summarise
from setcmas_ctrl.laws.script_output import named_output
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.script_calls import CurrentCall, Function
from setcmas_tools.offline import run_progress
from setcmas_tools.offline.run_progress import RunProgress

Result = TypeVar('Result')
Self = TypeVar('Self')  # as in `typing` from Python 3.11 on
Warn = Callable[[str], None]

UNGUARDED = (
    'a process for scripts did not begin; a script that starts processes, for example by sweep(), '
    "must do so below a line if __name__ == '__main__':"
)
"""Why a process ends before it begins: it begins with the main script of the user."""
_LOOK_S = 0.05
_STOPPED_S = 0.5  # as by Ctrl-Z: scripts may have waited until their output is shown
_PLACE_S = 2.0  # a process that waits for a core answers late
_LAST_S = 0.5
_MOST_READ = 1 << 16
_BROKEN = 70  # exit status
_ENVIRONMENT = {
    'PYTHONHASHSEED': '0',  # sets of texts have the same order in each run
    'OMP_NUM_THREADS': '1',
    'OPENBLAS_NUM_THREADS': '1',
}
_FRAME = re.compile(r'^  File "(?P<file>.*)", line (?P<line>\d+) in .*\n', re.MULTILINE)
_IS_POSIX = hasattr(signal, 'SIGUSR1') and hasattr(os, 'killpg')
_FORKS = sys.platform == 'linux' and hasattr(os, 'fork')
_context: Any = multiprocessing.get_context('forkserver' if _FORKS else 'spawn')
_context.set_forkserver_preload(['setcmas_tools.offline.offline_run'])
_starting = threading.Lock()


class StartError(SetcmasError):
    """A process for scripts does not start; the scripts are not the cause."""


@dataclass(eq=False)
class ScriptEndedError(Exception):
    """A script has ended its process, or has not returned in time, or broke what it ran in.

    Attributes:
        reason: The cause, with script and line where they are known.
        robot: Number of the robot whose script was called; 0 if unknown.
        function: The function that was called.
        file: Name of the file where it was; empty if unknown.
        line: The line there; 0 if unknown.
    """

    reason: str
    robot: int
    function: Function
    file: str = ''
    line: int = 0

    def __str__(self) -> str:
        return f'{robot_name(self.robot)}: {self.reason}' if self.robot else self.reason


class ScriptProcess(Generic[Result]):
    """A process that runs a function; use as a context manager, which ends the process.

    It begins with `result`. What scripts print appears on sys.stdout and sys.stderr.

    Attributes:
        progress: What it does, as it records it in `run_progress.current`.
        elapsed: How long the function took in s, without the start of the process.
    """

    def __init__(
        self, function: Callable[..., Result], scripts: Sequence[Path], size: int = 1
    ) -> None:
        """Prepare a function, which is pickled; its argument `warn` shows a message.

        Messages name places in the folders of its scripts. It may keep as many numbers as states
        as `size_of` says.
        """
        self.elapsed = self._begin = 0.0
        self._scripts = [path.resolve() for path in scripts]
        call, states = _context.RawValue(CurrentCall), _context.RawArray('d', size)
        self.progress = RunProgress(call, np.frombuffer(states))
        self._answers, answers = _context.Pipe(duplex=False)
        self._traces, traces = _context.Pipe(duplex=False)
        self._writers = answers, traces
        work = function, call, states, answers, traces, Path.cwd()
        self._process = _context.Process(target=_work, args=work, daemon=True)

    def __enter__(self: Self) -> Self:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.end()

    def result(
        self,
        warn: Warn,
        call_timeout: float = inf,
        timeout: float = inf,
        look: Callable[[], object] = lambda: None,
    ) -> Result:
        """Run the function; return its result. Call `look` now and then, and at the end.

        It is ended if a call of a script exceeds `call_timeout`, or the function `timeout`, in s.

        Raises:
            SetcmasError: The function raises it: the user's mistake.
            ScriptEndedError: A script has ended it, or lasts too long.
        """
        self._start()
        self._begin, call = time.monotonic(), self.progress.call
        before = self._begin
        while (answer := self._answer(warn)) is None:
            look()
            now = time.monotonic()
            if now - before > _STOPPED_S:
                call.since = now
            before = now
            if now - self._begin > timeout:
                raise self._ended(f'ended after {timeout:g} s (--timeout)')
            if call.running_s(now) > call_timeout:
                late = call.function.late(call.script, call_timeout)
                raise self._ended(f'{late} (--call-timeout)')
            if call.running_s(now) > STUCK_S and not call.is_reported:
                call.is_reported = True
                late = call.function.late(call.script, STUCK_S)
                warn(f'{robot_name(call.robot)}: {late}{self._place_after("; it is at ")}')
        self.end()
        kind, value = answer
        if kind == 'mistake':
            raise value
        if kind == 'broken':
            raise self._ended(f'the script has broken the simulation itself: {value}')
        look()
        result: Result
        result, self.elapsed = value
        return result

    def place(self) -> str:
        """Return the current place in the script as text; empty if unknown."""
        return self._place_after(' in ')

    def end(self) -> None:
        """End the process and its group: also the processes that scripts have started."""
        if self._process.pid is None:
            return
        if _IS_POSIX:
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self._process.pid, signal.SIGKILL)
        self._process.kill()
        self._process.join()

    def _start(self) -> None:
        try:
            with _starting, _environment():
                self._process.start()
        except (OSError, EOFError) as error:
            raise StartError(
                'this computer cannot run more processes for scripts; are memory, disk, and the '
                'limits of processes and open files (ulimit -u, -n) sufficient?'
            ) from error
        for writer in self._writers:
            writer.close()

    def _answer(self, warn: Warn) -> tuple[str, Any] | None:
        """Wait a moment for the answer, and show what comes before it."""
        try:
            if not self._answers.poll(_LOOK_S):
                if self._process.is_alive() or self._answers.poll():
                    return None
                raise EOFError
            kind, value = self._answers.recv()
        except EOFError:  # it has ended, or a script has closed everything
            self._process.join(_LAST_S)
            if not self.progress.call.calls:
                raise StartError(UNGUARDED) from None
            raise self._ended(self._death()) from None
        except Exception as error:  # a script may have put anything into the result
            return 'broken', summarise(error)
        if kind == 'warn':
            warn(value)
        elif kind in ('stdout', 'stderr'):
            getattr(sys, kind).write(value)
            getattr(sys, kind).flush()
        else:
            return kind, value
        return None

    def _death(self) -> str:
        status = self._process.exitcode
        if status is None:
            return 'the script has closed its connection with setcmas'
        if status == _BROKEN:
            return 'the script has broken the simulation itself'
        if status < 0:
            return f'the process of the script was killed by {signal.Signals(-status).name}'
        return f'the script ended its process with exit status {status}'

    def _ended(self, reason: str) -> ScriptEndedError:
        """End the process; return the error for it."""
        place, call = self._place(), self.progress.call
        self.end()
        if place:
            file, line, text = place
            return ScriptEndedError(
                f'{reason} at {text}', call.robot, call.function, file.name, line
            )
        script = call.script if call.robot else ''
        reason += f', in {call.function.value} of {script}' if script else ''
        return ScriptEndedError(reason, call.robot, call.function, script)

    def _place_after(self, words: str) -> str:
        """Return the place of the current call after some words; empty if unknown."""
        place = self._place()
        return f'{words}{place[2]}' if place else ''

    def _place(self) -> tuple[Path, int, str] | None:
        """Return file, line and text of the place where the script is or has died, if known."""
        if not _IS_POSIX:
            return None
        told, reader = '', self._traces
        deadline = time.monotonic()
        if self._process.is_alive() and self.progress.call.calls:
            deadline += _PLACE_S
            while reader.poll() and os.read(reader.fileno(), _MOST_READ):
                pass  # of an earlier question
            os.kill(self._process.pid, signal.SIGUSR1)
            os.kill(self._process.pid, signal.SIGCONT)  # a stopped one could not answer
        while reader.poll(max(0.0, deadline - time.monotonic())):
            part = os.read(reader.fileno(), _MOST_READ)  # it comes line by line
            told += part.decode(errors='replace')
            for found in _FRAME.finditer(told):
                file, line = Path(found['file']), int(found['line'])
                near = [path for path in self._scripts if path.parent == file.parent]
                if near:
                    there = described_place(file, line, file if file in near else near[0])
                    return file, line, there + quoted_line(file, line)
            if not part:
                break
        return None


@contextmanager
def _environment() -> Iterator[None]:
    """Let processes that start meanwhile have the workers' environment, and not see Ctrl-C."""
    multiprocessing.current_process().daemon = False  # Dask's workers are: they may start none
    before = {name: os.environ[name] for name in _ENVIRONMENT if name in os.environ}
    os.environ.update(_ENVIRONMENT)
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT]) if _IS_POSIX else ()
    try:
        yield
    finally:
        for name in _ENVIRONMENT:
            del os.environ[name]
        os.environ.update(before)
        if _IS_POSIX:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)


class _Printed(io.TextIOBase):
    """Takes what scripts print to the process that shows it."""

    def __init__(self, send: Callable[[str], None]) -> None:
        self._send = send

    def write(self, text: str) -> int:
        self._send(text)
        return len(text)


def _work(
    function: Callable[..., Any],
    call: CurrentCall,
    states: Any,
    answers: Connection,
    traces: Connection,
    folder: Path,
) -> None:
    """Run the function in this process, and end it."""
    process, lock = os.getpid(), threading.RLock()

    def send(kind: str, value: Any) -> None:
        with lock:  # threads of scripts may print
            answers.send((kind, value))

    _separate(traces, folder)
    sys.stdout, sys.stderr = _Printed(partial(send, 'stdout')), _Printed(partial(send, 'stderr'))
    run_progress.current = RunProgress(call, np.frombuffer(states))
    call.calls += 1  # it answers questions from now on
    answer: tuple[str, Any]
    status = _BROKEN
    try:
        with named_output():  # here, too, as threads of scripts print on after `simulate`
            try:
                begin = time.perf_counter()
                result = function(warn=partial(send, 'warn'))
                answer = 'result', (result, time.perf_counter() - begin)
            except SetcmasError as error:
                answer = 'mistake', error
            except BaseException as error:  # a script has changed what this process is made of
                answer = 'broken', summarise(error)
            if os.getpid() == process:  # otherwise a script has forked it
                send(*answer)
            status = 0
    finally:
        os._exit(status)  # whatever scripts have left, such as threads


def _separate(traces: Connection, folder: Path) -> None:
    """Give this process its own group; let it end with the process that started it."""
    _end_with_parent()
    multiprocessing.current_process().daemon = False  # scripts may start processes
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the other process answers Ctrl-C
    if _IS_POSIX:
        os.setsid()
        faulthandler.enable(traces.fileno(), all_threads=False)
        faulthandler.register(signal.SIGUSR1, traces.fileno(), all_threads=False)
    os.chdir(folder)


def _end_with_parent() -> None:
    """End this process when the one that started it has ended, however that ends."""
    parent = multiprocessing.parent_process()
    if parent and _FORKS:  # the kernel does it, even while a script holds the interpreter's lock
        import fcntl

        fcntl.fcntl(parent.sentinel, fcntl.F_SETOWN, os.getpid())
        fcntl.fcntl(parent.sentinel, fcntl.F_SETSIG, signal.SIGKILL)
        fcntl.fcntl(parent.sentinel, fcntl.F_SETFL, os.O_ASYNC)
    elif parent:
        threading.Thread(target=_exit_after, args=(parent,), daemon=True).start()


def _exit_after(parent: Any) -> None:
    parent.join()
    os._exit(1)
