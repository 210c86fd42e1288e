"""Sandbox: a process for what students hand in, confined by bubblewrap, and messages with it."""

from __future__ import annotations

import math
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import suppress
from typing import IO, cast

from setcmas_simu.errors import SetcmasError
from setcmas_tools.submissions.confined_program import READY, Connection
from setcmas_tools.submissions.confinement import HOME, PYTHON, confining_command, package_folders

_GRACE_S = 1.0  # a process that is late ends itself, and says where it was
_START_S = 60.0
_LOOK_S = 0.05
_ENDING_S = 2.0
_MOST_WRITTEN = 1 << 16
_PROGRAM = (
    'import sys; del sys.path[0]; sys.path += sys.argv[1:]; '
    'from setcmas_tools.submissions.confined_program import main; main()'
)
_ENVIRONMENT = {
    'PATH': os.defpath,
    'LANG': 'C.UTF-8',
    'PYTHONHASHSEED': '0',
    'PYTHONDONTWRITEBYTECODE': '1',
    **dict.fromkeys(
        ('OMP_NUM_THREADS', 'OPENBLAS_NUM_THREADS', 'MKL_NUM_THREADS', 'VECLIB_MAXIMUM_THREADS'),
        '1',
    ),
}


class NoProcessError(SetcmasError):
    """The machine keeps a submission from running; the submission is not the cause."""


class ProcessEndedError(Exception):
    """A confined process has ended or was ended; the message gives the reason.

    Attributes:
        trace: What it has written about the place where it was, which may be anything.
        was_killed: Whether something else has killed it, such as the kernel for lack of memory.
    """

    def __init__(self, message: str, trace: str = '', was_killed: bool = False) -> None:
        super().__init__(message, trace, was_killed)
        self.trace = trace
        self.was_killed = was_killed

    def __str__(self) -> str:
        return str(self.args[0])


class ConfinedProcess:
    """A process for one submission; use as a context manager, which leaves nothing of it.

    Each message has a largest size and a deadline, after which the process is killed.
    """

    def __init__(self, is_confined: bool, work: bytes) -> None:
        """Start it with some work.

        Args:
            is_confined: Whether it is confined; otherwise it can do whatever this user can.
            work: The work, for `confined_program`.

        Raises:
            NoProcessError: It does not start.
        """
        self._is_confined = is_confined
        self._home = '' if is_confined else tempfile.mkdtemp(prefix='setcmas_')
        self._deadline = time.monotonic() + _START_S
        self._is_closed = threading.Event()
        try:
            self._process = subprocess.Popen(
                self._command(),
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                cwd=self._home or '/', env=self._environment(),
                start_new_session=True,  # Ctrl-C is answered here
            )  # fmt: skip
        except OSError as error:
            raise _machine_error(error.strerror or '') from error
        streams = self._process.stdin, self._process.stdout, self._process.stderr
        self._streams = [cast(IO[bytes], stream) for stream in streams]
        requests, answers, self._errors = self._streams
        self._connection = Connection(answers, requests)
        threading.Thread(target=self._watch, daemon=True).start()
        try:
            self._connection.send(work)
            if self._connection.receive(len(READY)) != READY:
                raise EOFError
        except (OSError, EOFError):
            raise _machine_error(self._end(_ENDING_S)[1].strip().rpartition('\n')[2]) from None

    def __enter__(self) -> ConfinedProcess:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self._end()

    def answer(self, request: bytes, timeout: float, late: str, most: int) -> bytes:
        """Return the answer to a request.

        Args:
            request: The request; empty for none.
            timeout: How long the answer may take, in s.
            late: The reason if it takes longer.
            most: Size of the largest answer in bytes.

        Raises:
            ProcessEndedError: The process has ended, is late, or sends what it must not.
        """
        begin = time.monotonic()
        self._deadline = begin + timeout + _GRACE_S
        try:
            if request:
                self._connection.send(request)
            message = self._connection.receive(most)
        except (OSError, EOFError):
            is_late = time.monotonic() > begin + timeout
            status, written = self._end(_ENDING_S)
            was_killed = status == -signal.SIGKILL and not is_late
            raise ProcessEndedError(
                late if is_late else _death(status), written, was_killed
            ) from None
        except ValueError:
            self._end()
            raise ProcessEndedError('the script wrote on its connection with the grader') from None
        self._deadline = math.inf
        return message

    def _command(self) -> list[str]:
        places = [place for place in sys.path if place]
        python = sys.executable
        before: list[str] = []
        if self._is_confined:
            before, python, places = confining_command(), PYTHON, package_folders()
        return [*before, python, '-s', '-c', _PROGRAM, *places]

    def _environment(self) -> dict[str, str]:
        home = self._home or HOME
        return {**_ENVIRONMENT, **dict.fromkeys(('HOME', 'TMPDIR', 'MPLCONFIGDIR'), home)}

    def _watch(self) -> None:
        """Kill the process when its deadline has passed: all reads and writes end then."""
        while not self._is_closed.wait(_LOOK_S):
            if time.monotonic() > self._deadline:
                self._kill()
                return

    def _kill(self) -> None:
        with suppress(OSError):
            if hasattr(os, 'killpg'):
                os.killpg(self._process.pid, signal.SIGKILL)
            else:
                self._process.kill()

    def _end(self, seconds: float = 0.0) -> tuple[int | None, str]:
        """End the process; return its exit status, and what it has written at last.

        Args:
            seconds: How long it may take to end by itself; the status is None if it does not.
        """
        if self._is_closed.is_set():
            return None, ''
        self._is_closed.set()
        status = None
        with suppress(subprocess.TimeoutExpired):
            status = self._process.wait(seconds)
        self._kill()  # and what it has started
        self._process.wait()
        written = b''
        os.set_blocking(self._errors.fileno(), False)
        with suppress(BlockingIOError):
            written = self._errors.read(_MOST_WRITTEN) or b''
        for stream in self._streams:
            with suppress(OSError):  # unread requests are lost
                stream.close()
        if self._home:
            shutil.rmtree(self._home, ignore_errors=True)
        if status is not None and status > 128:  # of bubblewrap: signal N has killed the program
            status = 128 - status
        return status, written.decode(errors='replace')


def _machine_error(reason: str) -> NoProcessError:
    return NoProcessError(
        f'this computer cannot run more processes for scripts{reason and f" ({reason})"}; are '
        'memory, disk and number of processes sufficient?'
    )


def _death(status: int | None) -> str:
    if status is None:
        return 'the script closed its connection with the grader'
    if status == -getattr(signal, 'SIGXCPU', 0):
        return 'the script took too much processor time'
    if status < 0:
        with suppress(ValueError):
            return f'the process of the script was killed by {signal.Signals(-status).name}'
    return f'the script ended its process with exit status {status}'
