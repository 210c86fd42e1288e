"""Process of a `Host`: runs each work in a copy of itself, and ends it with all that it started.

Its arguments are FOLDER PREPARE ISOLATION; orders come on a socket, its standard input. An order
to begin comes with the socket on which the copy (fork) receives its work, a pickled function. The
process of a confined host knows Python, numpy and what scripts import of setcmas, but no rubric,
no solution, no other submission, and nothing of the user's environment.
"""

from __future__ import annotations

import enum
import faulthandler
import gc
import importlib
import math
import os
import pickle
import re
import shutil
import signal
import socket
import struct
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import IO, Any, NoReturn

from setcmas_tools.offline.confinement import (
    OPEN_FILES,
    call_filter,
    confine_files,
    limit_amounts,
)
from setcmas_tools.offline.host_channel import Channel
from setcmas_tools.offline.process_tree import adopt_orphans, end_orphans, end_with_parent

FORKS = hasattr(os, 'fork')
BEGIN, PLACE, END, WAIT = b'b', b'?', b'x', b'w'
"""Orders: begin some work, write where its process is, end it, wait for its end."""
READY = b'r'
"""Answer of a process that is prepared."""
NUMBER = struct.Struct('<i')
"""Process ID of a copy that has begun, and its exit status once it has ended."""

_PLACES = 'where'
_MOST_READ = 1 << 15
# A confined process may write anything: lines of more than nine digits are none.
_FRAME = re.compile(r'^  File "(?P<file>.*)", line (?P<line>\d{1,9}) in ', re.MULTILINE)
_WAIT_S = 0.5
_exit = os._exit


class Isolation(enum.Enum):
    """What copies may do.

    NONE: whatever the user can, in the user's folder and environment. HOME: the same, in a home
    and an environment of their own. CONFINED: in that home, and the kernel keeps them there.
    """

    NONE = enum.auto()
    HOME = enum.auto()
    CONFINED = enum.auto()


class Copy:
    """The copy that runs now; there is at most one."""

    def __init__(
        self, folder: Path, isolation: Isolation, confine: Callable[[], None] | None
    ) -> None:
        """Prepare.

        Args:
            folder: Where it writes.
            isolation: What it may do.
            confine: Filters its system calls; None for one that is not confined.
        """
        self._folder = folder
        self._isolation = isolation
        self._confine = confine
        self._process = 0

    def begin(self, end: int) -> int:
        """Begin with the work that comes on a socket; returns the process ID."""
        self._process = os.fork()
        if not self._process:
            os.setsid()
            end_with_parent()
            os.dup2(end, 3, inheritable=False)
            os.closerange(4, OPEN_FILES)
            self.work(socket.socket(fileno=3))
        os.close(end)
        return self._process

    def ask_place(self) -> None:
        """Let the copy write where it is."""
        if self._process:
            os.kill(self._process, signal.SIGUSR1)

    def end(self, wait_s: float = 0.0) -> int:
        """End the copy and all that it started; returns its exit status, 0 if there is none.

        Args:
            wait_s: For how long it may take to end by itself.
        """
        if not self._process:
            return 0
        ended, status, deadline = 0, 0, time.monotonic() + wait_s
        while not ended and time.monotonic() < deadline:
            ended, status = os.waitpid(self._process, os.WNOHANG)
            time.sleep(0.0 if ended else 0.002)
        if not ended:
            os.kill(self._process, signal.SIGKILL)
            _, status = os.waitpid(self._process, 0)
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(self._process, signal.SIGKILL)
        self._process = 0
        if not self._confine:
            end_orphans(set())
        return os.waitstatus_to_exitcode(status)

    def work(self, end: socket.socket) -> NoReturn:
        """Run the work that comes on a socket in this process, and end it."""
        status = 1
        with suppress(BaseException):  # such as where a script has closed the socket
            if self._isolation is not Isolation.NONE:
                os.chdir(self._folder)
            write_places(self._folder)
            if hasattr(signal, 'SIGALRM'):  # a script's alarm does nothing, as over ROS
                signal.signal(signal.SIGALRM, lambda *_: None)
            channel = Channel(end, sys.maxsize)
            limits, work = pickle.loads(channel.receive(math.inf))
            limit_amounts(limits)
            function = pickle.loads(work)
            if self._confine:
                self._confine()
            function(channel, self._folder)
            for stream in (sys.__stdout__, sys.__stderr__):
                if stream is not None and not stream.closed:
                    stream.flush()
            status = 0
        _exit(status)


def write_places(folder: Path) -> None:
    """Let this process write where it is into a folder when it is asked, crashes or ends."""
    file = (folder / _PLACES).open('w', encoding='utf-8')
    faulthandler.enable(file, all_threads=False)
    if hasattr(signal, 'SIGUSR1'):
        faulthandler.register(signal.SIGUSR1, file, all_threads=False)
        print('may be asked', file=file, flush=True)
    os._exit = _writing(os._exit, file)
    os.kill = _writing(os.kill, file)
    signal.raise_signal = _writing(signal.raise_signal, file)


def places_size(folder: Path) -> int:
    """Return how much a process has written of its places, in bytes."""
    try:
        return (folder / _PLACES).lstat().st_size
    except OSError:
        return 0


def last_places(folder: Path, since: int = 0) -> list[tuple[Path, int]]:
    """Return the files and lines of the calls that a process wrote last, the innermost first.

    Args:
        folder: Where it writes.
        since: Size of its file before; what was written earlier does not count.
    """
    with suppress(OSError), (folder / _PLACES).open('rb') as file:
        file.seek(max(since, places_size(folder) - _MOST_READ))
        whole = file.read(_MOST_READ).rpartition(b'\n')[0].decode(errors='replace')
        last = whole.rpartition('(most recent')[2]
        return [(Path(found['file']), int(found['line'])) for found in _FRAME.finditer(last)]
    return []


def main() -> NoReturn:
    """Run work until there is none."""
    folder, isolation = Path(sys.argv[1]), Isolation[sys.argv[3]]
    orders = _orders()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # for the other process to answer
    os.dup2(nowhere := os.open(os.devnull, os.O_RDWR), 0)
    adopt_orphans()
    module, _, function = sys.argv[2].partition(':')
    confine = call_filter() if isolation is Isolation.CONFINED else None
    getattr(importlib.import_module(module), function)()
    if confine:
        confine_files(folder)
    if isolation is not Isolation.NONE:
        os.dup2(nowhere, 2)
    orders.sendall(READY)
    gc.freeze()  # or else a copy would touch, and so copy, the memory of all
    copy = Copy(folder, isolation, confine)
    if not FORKS:
        copy.work(orders)
    while True:
        order, ends, _, _ = socket.recv_fds(orders, 1, 1)
        if ends:
            orders.sendall(NUMBER.pack(copy.begin(ends[0])))
        elif order == PLACE:
            copy.ask_place()
        elif order in (END, WAIT):
            orders.sendall(NUMBER.pack(copy.end(_WAIT_S if order == WAIT else 0.0)))
        else:
            copy.end()
            shutil.rmtree(folder, ignore_errors=True)
            _exit(0)


def _orders() -> socket.socket:
    if sys.platform == 'win32':
        return socket.fromshare(sys.stdin.buffer.read())
    return socket.socket(fileno=os.dup(0))


def _writing(function: Callable[..., Any], file: IO[str]) -> Callable[..., Any]:
    def write_and_call(*args: Any) -> Any:
        faulthandler.dump_traceback(file, all_threads=False)
        return function(*args)

    return write_and_call
