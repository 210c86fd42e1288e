"""Box that holds one submission at a time in a process of its own, and kills what does not answer.

Its process and its folder stay from one submission to the next; a submission is held by a copy.
"""

from __future__ import annotations

import os
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

import msgspec

from setcmas_simu.errors import SetcmasError
from setcmas_tools.grade.sandbox.channel import Channel, ChannelError, LateError
from setcmas_tools.grade.sandbox.job import EXIT, MOST_ANSWERED, NUMBER, PLACE, READY, Job
from setcmas_tools.grade.sandbox.signs import check_written, hindered, last_place, told_size

_ANSWER_S = 0.5
_START_S = 30.0
_MOST_HINDERED_S = 600.0
# Nothing of a submission is imported before it is confined: neither the current folder nor the
# user's packages (-s), which are in the home, are searched. Python 3.10 has no -P for the first.
_HOST = 'import sys; del sys.path[0]; from setcmas_tools.grade.sandbox import host; host.main()'
_ONE_THREAD = dict.fromkeys(('OMP_NUM_THREADS', 'OPENBLAS_NUM_THREADS', 'MKL_NUM_THREADS'), '1')


class EndedError(Exception):
    """A submission does not answer any more; the message says why.

    Attributes:
        file: Name of the file that it was in last; empty if that is not known.
        line: The line there.
    """

    file = ''
    line = 0


class Box:
    """A process that holds submissions; use as a context manager, which leaves nothing behind."""

    def __init__(self, folder: Path, confined: bool) -> None:
        """Prepare.

        Args:
            folder: Gets the box's own folder; whoever gives it removes it.
            confined: Whether the kernel keeps submissions in; else they are trusted.
        """
        self._folder = folder
        self._home = self._new_home()
        self._confined = confined
        self._process: subprocess.Popen[bytes] | None = None
        self._orders = socket.socket(socket.AF_UNIX)
        self._channel: Channel | None = None
        self._number = 0
        self._hindered: float | None = None

    def __enter__(self) -> Box:
        """Return the box."""
        return self

    def __exit__(self, *exc_info: object) -> None:
        """End the process."""
        self.drop()
        self._stop()

    def hold(self, files: Mapping[str, bytes], job: Job) -> None:
        """Let the box hold a submission.

        Args:
            files: Its files by their names, which may have folders.
            job: What to load.

        Raises:
            SetcmasError: The process of the box does not start.
        """
        self.drop()
        try:
            self._clear()
        except OSError:  # the last one has left what cannot be removed
            self._stop()
            self._home = self._new_home()
        self._start()
        self._fill(files)
        own, theirs = socket.socketpair()
        with theirs:
            socket.send_fds(self._orders, [msgspec.json.encode(job)], [theirs.fileno()])
        self._number = NUMBER.unpack(self._orders.recv(NUMBER.size))[0]
        self._channel = Channel(own, MOST_ANSWERED, self._look)

    def ask(self, request: bytes, timeout: float, late: str) -> bytes:
        """Return what the submission answers to a request; an empty one only waits.

        Args:
            request: The request.
            timeout: How long it may take, in s.
            late: What to say if it takes longer.

        Raises:
            EndedError: It has ended, or was ended because it took too long or too much.
        """
        deadline = time.monotonic() + timeout
        self._hindered = None
        assert self._channel
        try:
            if request:
                self._channel.send(request, deadline)
            return self._channel.receive(deadline)
        except LateError:
            ended, place = EndedError(late), self._place(ask=True)
        except ChannelError as error:
            ended, place = EndedError(str(error) or _death(self.drop())), self._place(ask=False)
        self.drop()
        ended.file, ended.line = place
        raise ended

    def drop(self) -> int:
        """End what the box holds; returns its exit status, 0 if it holds nothing."""
        if self._channel is None:
            return 0
        self._channel.close()
        self._channel = None
        try:
            self._orders.sendall(EXIT)
            return int(NUMBER.unpack(self._orders.recv(NUMBER.size))[0])
        except (OSError, struct.error):
            self._stop()
            return -signal.SIGKILL

    def _new_home(self) -> Path:
        return Path(tempfile.mkdtemp(dir=self._folder)).resolve()

    def _start(self) -> None:
        if self._process and self._process.poll() is None:
            return
        self._orders.close()
        self._orders, theirs = socket.socketpair()
        self._orders.settimeout(_START_S)
        places = os.pathsep.join(place for place in sys.path if place)
        home = str(self._home)
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, '-s', '-c', _HOST, home,
                 'confined' if self._confined else 'trusted'],
                stdin=theirs.fileno(),
                stdout=subprocess.DEVNULL,
                cwd='/',
                env={
                    **_ONE_THREAD, 'HOME': home, 'TMPDIR': home, 'MPLCONFIGDIR': home,
                    'PATH': os.defpath, 'LANG': 'C.UTF-8', 'PYTHONPATH': places,
                    'PYTHONHASHSEED': '0', 'PYTHONDONTWRITEBYTECODE': '1',
                },
                start_new_session=True,  # Ctrl-C is answered here
            )  # fmt: skip
        ready = b''
        with suppress(OSError):
            ready = self._orders.recv(len(READY))
        if ready != READY:
            raise SetcmasError('the sandbox does not start; --trust grades without')

    def _stop(self) -> None:
        self._orders.close()
        if self._process:
            self._process.kill()
            self._process.wait()
            self._process = None

    def _clear(self) -> None:
        for old in self._home.iterdir():
            if old.is_dir() and not old.is_symlink():
                shutil.rmtree(old)
            else:
                old.unlink()

    def _fill(self, files: Mapping[str, bytes]) -> None:
        for name, content in files.items():
            (self._home / name).parent.mkdir(parents=True, exist_ok=True)
            (self._home / name).write_bytes(content)

    def _look(self) -> float:
        """Return how long others have kept the submission from running since it was asked, in s.

        Raises:
            ChannelError: It has written too much.
        """
        check_written(self._home)
        now = hindered(self._number)
        if self._hindered is None:
            self._hindered = now
        return min(now - self._hindered, _MOST_HINDERED_S)

    def _place(self, ask: bool) -> tuple[str, int]:
        """Return file and line of the script where it is, or was last; ('', 0) if unknown."""
        if ask:
            told = told_size(self._home)
            with suppress(OSError):
                self._orders.sendall(PLACE)
            deadline = time.monotonic() + _ANSWER_S
            while told_size(self._home) == told and time.monotonic() < deadline:
                time.sleep(0.01)
        return last_place(self._home)


def _death(status: int) -> str:
    if status == -getattr(signal, 'SIGXCPU', 0):
        return 'the script took too much processor time'
    if status < 0:
        return f'the process of the script was killed by {signal.Signals(-status).name}'
    return f'the script ended its process with exit status {status}'
