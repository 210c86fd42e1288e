"""Runs in processes of their own, which are kept from run to run and replaced when they break."""

from __future__ import annotations

import os
import pickle
import queue
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory

import msgspec

from setcmas_tools.run.run_info import State
from setcmas_tools.study.study_job import Job
from setcmas_tools.study.study_row import Row

_GRACE_S = 15.0
"""Time for a process to begin, and to tell that a run is late."""

_ONE_THREAD = dict.fromkeys(
    ('OMP_NUM_THREADS', 'OPENBLAS_NUM_THREADS', 'MKL_NUM_THREADS', 'VECLIB_MAXIMUM_THREADS'), '1'
)

_own = threading.local()
_all: list[Runner] = []


class Runner:
    """A process that makes runs for one thread."""

    def __init__(self) -> None:
        """Start the process."""
        self._folder = TemporaryDirectory(prefix='setcmas_')
        path = os.pathsep.join(place or str(Path.cwd()) for place in sys.path)  # of functions
        self._process = subprocess.Popen(
            [sys.executable, '-m', 'setcmas_tools.study.study_runner', self._folder.name],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, **_ONE_THREAD, 'PYTHONPATH': path},
            start_new_session=True,  # Ctrl-C is answered by whoever made it
        )
        self._lines: queue.SimpleQueue[bytes] = queue.SimpleQueue()
        threading.Thread(target=self._read, daemon=True).start()

    def row(self, job: Job) -> Row:
        """Make a run and return its row, whatever its scripts do."""
        assert self._process.stdin
        with suppress(OSError):
            pickle.dump(job, self._process.stdin)
            self._process.stdin.flush()
        line = b''
        with suppress(queue.Empty):
            line = self._lines.get(timeout=job.timeout + _GRACE_S)
        if line:
            return msgspec.json.decode(line, type=Row)
        self.close()
        message = f'the process ended, or took longer than {job.timeout:g} s (--timeout)'
        return Row(run=job.run, state=State.DIED, message=message)

    @property
    def is_closed(self) -> bool:
        """Whether it makes no more runs."""
        return self._process.poll() is not None

    def close(self) -> None:
        """End the process, and a run that it is in."""
        assert self._process.stdin
        with suppress(OSError):
            self._process.stdin.close()
        try:
            self._process.wait(2.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._folder.cleanup()

    def _read(self) -> None:
        assert self._process.stdout
        with self._process.stdout as lines:
            for line in lines:
                self._lines.put(line)
        self._lines.put(b'')


def make_row(job: Job) -> Row:
    """Make a run in the process of this thread, and return its row."""
    runner: Runner | None = getattr(_own, 'runner', None)
    if runner is None or runner.is_closed:
        runner = _own.runner = Runner()
        _all.append(runner)
    return runner.row(job)


def close_runners() -> None:
    """End the processes of all threads."""
    while _all:
        _all.pop().close()
