"""Host: a process that runs work with scripts in copies of itself; each is watched from here."""

from __future__ import annotations

import math
import os
import pickle
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Collection, Mapping
from contextlib import suppress
from pathlib import Path

from setcmas_simu.errors import SetcmasError
from setcmas_tools.offline.host_channel import LOOK_S, Channel, ChannelError, LateError
from setcmas_tools.offline.host_process import (
    BEGIN,
    END,
    FORKS,
    NUMBER,
    PLACE,
    READY,
    WAIT,
    Isolation,
    last_places,
    places_size,
)

_START_S = 30.0
_PLACE_S = 2.0  # a process that waits for a core answers late
_CLOSE_S = 2.0 if FORKS else 0.2
_MOST_WAITED_S = 600.0
_MOST_ANSWERED = 1 << 13
_MOST_WRITTEN = 1 << 26  # bytes in all files of an isolated copy
_MOST_FILES = 1000
# The current folder stays out of the search path, or else a file such as random.py in a student's
# folder would hide Python's own. Python 3.10 has no option for it.
_PROGRAM = (
    'import sys; del sys.path[0]; from setcmas_tools.offline import host_process; '
    'host_process.main()'
)
_ONE_THREAD = dict.fromkeys(
    ('OMP_NUM_THREADS', 'OPENBLAS_NUM_THREADS', 'MKL_NUM_THREADS', 'VECLIB_MAXIMUM_THREADS'), '1'
)


class EndedError(Exception):
    """A copy does not answer any more; the message says why.

    Attributes:
        status: Its exit status, or the number of the signal that killed it, negative.
        places: Files and lines of the calls that it was in, the innermost first.
    """

    def __init__(self, message: str, status: int, places: list[tuple[Path, int]]) -> None:
        """Take the cause and the place of the end."""
        super().__init__(message)
        self.status = status
        self.places = places


class Host:
    """A process that runs work with scripts, each time in a copy (fork) of itself.

    A copy takes a few milliseconds, has everything imported, and takes with it whatever a script
    does to its process. Without fork (Windows) each work has a new process. Use as a context
    manager, which leaves no process and no file.

    Attributes:
        folder: Where a copy finds its files; changes if an isolated one leaves what cannot be
            removed.
        process: The process; None before the first work.
    """

    def __init__(
        self,
        prepare: str,
        isolation: Isolation = Isolation.NONE,
        environment: Mapping[str, str] | None = None,
        output: int = subprocess.DEVNULL,
        place: Path | None = None,
    ) -> None:
        """Prepare; the process starts with the first work.

        Args:
            prepare: Function 'module:name' that imports what all copies need, called once.
            isolation: What the copies may do.
            environment: Further variables of its environment.
            output: Where what scripts print goes: nowhere, or to pipes (subprocess.PIPE).
            place: Gets the folder of the copies; by default that of temporary files.
        """
        self._prepare = prepare
        self._isolation = isolation
        self._environment = environment or {}
        self._output = output
        self.process: subprocess.Popen[bytes] | None = None
        self._place = place
        self.folder = self._new_folder()
        self._orders = socket.socket()
        self._channel: Channel | None = None
        self._number = 0
        self._waited: float | None = None
        self._looked = 0.0

    def __enter__(self) -> Host:
        """Return the host."""
        return self

    def __exit__(self, *exc_info: object) -> None:
        """End it."""
        self.close()

    def begin(
        self,
        work: bytes,
        files: Mapping[str, bytes] | None = None,
        limits: Mapping[str, int] | None = None,
    ) -> None:
        """Begin some work in a copy, after the end of earlier work.

        Args:
            work: A pickled function that takes the `Channel` of the copy and the folder.
            files: What the folder is to hold, by names, which may have folders.
            limits: Most of each resource that the copy may take, such as {'AS': bytes}.

        Raises:
            SetcmasError: The process does not start.
        """
        self.end()
        self._clear()
        for name, content in (files or {}).items():
            (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
            (self.folder / name).write_bytes(content)
        self._start()
        own = self._orders
        if FORKS:
            own, theirs = socket.socketpair()
            with theirs:
                socket.send_fds(self._orders, [BEGIN], [theirs.fileno()])
            (self._number,) = NUMBER.unpack(self._orders.recv(NUMBER.size))
        most = sys.maxsize if self._isolation is Isolation.NONE else _MOST_ANSWERED
        self._channel = Channel(own, most, self._look)
        self._waited = None
        self.send(pickle.dumps((dict(limits or {}), work)), math.inf)

    def send(self, message: bytes, timeout: float) -> None:
        """Send a message to the copy; if it does not take it, the next `receive` says why."""
        with suppress(ChannelError):
            if self._channel:
                self._channel.send(message, time.monotonic() + timeout)

    def poll(self, timeout: float) -> bytes | None:
        """Return the next message of the copy; None if none comes in this time, in s.

        Raises:
            EndedError: The copy has ended, or was ended because it wrote too much.
        """
        self._waited = None
        message = ''
        try:
            if self._channel:
                if time.monotonic() > self._looked + LOOK_S:
                    self._look()
                return self._channel.receive(time.monotonic() + timeout)
        except LateError:
            return None
        except ChannelError as error:
            message = str(error)
        status = self.end(END if message else WAIT)
        raise EndedError(message or _death(status), status, last_places(self.folder))

    def receive(self, timeout: float, late: str, scripts: Collection[Path]) -> bytes:
        """Return the next message of the copy, which ends if it takes too long.

        Time in which it could run but others had the cores does not count (Linux).

        Args:
            timeout: How long it may take, in s.
            late: The message if it takes longer.
            scripts: As for `places`.

        Raises:
            EndedError: It has ended, or was ended because it took too long or wrote too much.
        """
        answer = self.poll(timeout)
        if answer is not None:
            return answer
        places = self.places(scripts)
        raise EndedError(late, self.end(), places)

    def places(self, scripts: Collection[Path]) -> list[tuple[Path, int]]:
        """Return files and lines of the calls that the copy is in, or was last, innermost first.

        Args:
            scripts: Folders of the scripts; waits for a place in one of them.
        """
        before = places_size(self.folder)
        if not before or not self._channel or not FORKS:  # a signal would kill it
            return last_places(self.folder)
        with suppress(OSError):
            self._orders.sendall(PLACE)
        deadline = time.monotonic() + _PLACE_S
        while time.monotonic() < deadline:  # it comes line by line
            if script_of(found := last_places(self.folder, before), scripts):
                return found
            time.sleep(0.01)
        return last_places(self.folder)

    def end(self, order: bytes = END) -> int:
        """End the copy and all that it started; returns its exit status, 0 if there is none.

        Args:
            order: END, or WAIT to give it time to end by itself.
        """
        if self._channel is None:
            return 0
        channel, self._channel = self._channel, None
        if not FORKS:
            return self._stop()
        channel.close()
        try:
            self._orders.sendall(order)
            return int(NUMBER.unpack(self._orders.recv(NUMBER.size))[0])
        except (OSError, struct.error):
            self._stop()
            return -signal.SIGKILL

    def close(self) -> None:
        """End the process, and remove its folder."""
        self.end()
        self._stop()
        shutil.rmtree(self.folder, ignore_errors=True)

    def _start(self) -> None:
        if self.process and self.process.poll() is None:
            return
        self._stop()
        self._orders, theirs = socket.socketpair()
        self._orders.settimeout(_START_S)
        isolated = self._isolation is not Isolation.NONE
        environment = self._isolated_environment() if isolated else {**_ONE_THREAD, **os.environ}
        with theirs:
            self.process = subprocess.Popen(
                [sys.executable, *(['-s'] if isolated else []), '-c', _PROGRAM,
                 str(self.folder), self._prepare, self._isolation.name],
                stdin=subprocess.PIPE if sys.platform == 'win32' else theirs.fileno(),
                stdout=self._output,
                stderr=None if isolated else self._output,  # until it is prepared
                cwd='/' if isolated else None,
                env={**environment, 'PYTHONHASHSEED': '0', **self._environment},
                start_new_session=True,  # Ctrl-C is answered here
            )  # fmt: skip
            if sys.platform == 'win32':
                assert self.process.stdin
                self.process.stdin.write(theirs.share(self.process.pid))
                self.process.stdin.close()
        ready = b''
        with suppress(OSError):
            ready = self._orders.recv(len(READY))
        if ready != READY:
            raise SetcmasError('the process for scripts does not start; is there enough memory?')

    def _isolated_environment(self) -> dict[str, str]:
        """Return variables that say nothing of this user.

        Nothing of a submission is imported before it is confined: neither the current folder nor
        the user's packages (-s), which are in the home, are searched.
        """
        home = str(self.folder)
        return {
            **_ONE_THREAD, 'HOME': home, 'TMPDIR': home, 'MPLCONFIGDIR': home,
            'PATH': os.defpath, 'LANG': 'C.UTF-8',
            'PYTHONPATH': os.pathsep.join(place for place in sys.path if place),
            'PYTHONHASHSEED': '0', 'PYTHONDONTWRITEBYTECODE': '1',
        }  # fmt: skip

    def _stop(self) -> int:
        """End the process; returns its exit status."""
        self._orders.close()
        if not self.process:
            return 0
        try:
            self.process.wait(_CLOSE_S)  # it ends what runs in it
        except subprocess.TimeoutExpired:
            self.process.kill()
        return self.process.wait()

    def _clear(self) -> None:
        try:
            for old in self.folder.iterdir():
                if old.is_dir() and not old.is_symlink():
                    shutil.rmtree(old)
                else:
                    old.unlink()
        except OSError:  # a confined process knows this folder, and no other
            self._stop()
            shutil.rmtree(self.folder, ignore_errors=True)
            self.folder = self._new_folder()

    def _new_folder(self) -> Path:
        return Path(tempfile.mkdtemp(prefix='setcmas_', dir=self._place)).resolve()

    def _look(self) -> float:
        """Return how long others have kept the copy from running since it was asked, in s.

        Raises:
            ChannelError: It has ended, though something that it started goes on, or it has
                written too much.
        """
        self._looked = time.monotonic()
        if self._isolation is not Isolation.NONE:
            _check_written(self.folder, self._number)
        if _is_dead(self._number) and not (self._channel and self._channel.has_more()):
            raise ChannelError
        now = _waited_s(self._number)
        if self._waited is None:
            self._waited = now
        return min(now - self._waited, _MOST_WAITED_S)


def script_of(
    places: Collection[tuple[Path, int]], folders: Collection[Path]
) -> tuple[Path, int] | None:
    """Return the first of some places, file and line, in one of these folders."""
    return next(((file, line) for file, line in places if file.parent in folders), None)


def _waited_s(process: int) -> float:
    """Return how long a process could have run but had to wait for a core, in s (Linux)."""
    try:
        return int(Path(f'/proc/{process}/schedstat').read_text().split()[1]) / 1e9
    except (OSError, ValueError, IndexError):
        return 0.0


def _is_dead(process: int) -> bool:
    """Return whether a process has ended and only its number is left (Linux)."""
    try:
        return Path(f'/proc/{process}/stat').read_text().rpartition(')')[2].split()[0] == 'Z'
    except (OSError, IndexError):
        return False


def _check_written(folder: Path, process: int) -> None:
    """Check how much a process has in files: those of its folder, and open ones without a name.

    Raises:
        ChannelError: It is too much.
    """
    count = size = 0
    for inside, _, names in os.walk(folder):
        for name in names:
            count += 1
            with suppress(OSError):
                size += Path(inside, name).lstat().st_size
    with suppress(OSError):
        for file in Path(f'/proc/{process}/fd').iterdir():
            with suppress(OSError):
                status = file.stat()
                size += 0 if status.st_nlink else 512 * status.st_blocks
    if count > _MOST_FILES or size > _MOST_WRITTEN:
        raise ChannelError(
            f'the script wrote more than {_MOST_WRITTEN >> 20} MB or {_MOST_FILES} files'
        )


def _death(status: int) -> str:
    if status == -getattr(signal, 'SIGXCPU', 0):
        return 'the script took too much processor time'
    if status < 0:
        return f'the process of the script was killed by {signal.Signals(-status).name}'
    return f'the script ended its process with exit status {status}'
