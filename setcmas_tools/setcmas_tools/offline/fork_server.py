"""Process of a `Host`: forks a child for each work, and ends it with all that it started.

Its arguments are FOLDER PREPARE ISOLATION; it gets orders on a socket, its standard input. With an
order to begin comes the socket on which the child receives its work, a pickled function. The
process of a confined host has Python, numpy and what scripts import of setcmas, but no rubric, no
solution, no other submission, and nothing of the user's environment. Its children share nothing:
each has its own folder, streams, mounts and domain of Landlock.
"""

from __future__ import annotations

import ctypes
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

from setcmas_tools.offline.child_channel import Channel
from setcmas_tools.offline.kernel_confinement import MOST_DESCRIPTORS, Confinement, limit_amounts

FORKS = hasattr(os, 'fork')
ORDER = struct.Struct('<ci')
"""An order, and the process ID of its child; 0 for a new one."""
BEGIN, PLACE, END, WAIT = b'b', b'?', b'x', b'w'
"""Begin work; write the child's current calls; end it; wait for its end, then end it."""
READY, READY_WITH_MOUNTS = b'r', b'm'
"""Answers of a prepared process: without and with private mounts."""
NUMBER = struct.Struct('<i')
"""Process ID of a child that has begun, 0 if none can; or its exit status once it has ended."""
BEGUN = b''
"""First message of a child, before anything of a script runs."""
HOME = 'HOME'
"""Limit of `Host.begin` on what a confined child may write, in bytes."""

HOMES = ('HOME', 'TMPDIR', 'MPLCONFIGDIR')
"""Variables of the environment that name the folder of an isolated child."""

_PLACES = 'where'
_MOST_READ = 1 << 15
# A confined process may write anything: lines of more than nine digits are none.
_FRAME = re.compile(r'^  File "(?P<file>.*)", line (?P<line>\d{1,9}) in ', re.MULTILINE)
_WAIT_S = 0.5
_exit = os._exit
_PR_SET_PDEATHSIG = 1
_PR_SET_CHILD_SUBREAPER = 36


def end_with_parent() -> None:
    """Let the kernel end this process when its parent has ended (Linux)."""
    if sys.platform == 'linux':
        parent = os.getppid()
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:
            os._exit(1)


def adopt_orphans() -> None:
    """Become the parent of processes that descendants of this one leave behind (Linux)."""
    if sys.platform == 'linux':
        ctypes.CDLL(None).prctl(_PR_SET_CHILD_SUBREAPER, 1)


def children() -> set[int]:
    """Return the process IDs of the children of this process (Linux)."""
    found: set[int] = set()
    for tasks in Path('/proc/self/task').glob('*/children'):
        with suppress(OSError):
            found |= {int(word) for word in tasks.read_text().split()}
    return found


def end_orphans(known: set[int]) -> None:
    """Kill the children of this process but for known ones, and the children that those leave."""
    while strangers := children() - known:
        for pid in strangers:
            with suppress(ProcessLookupError, PermissionError):
                os.kill(pid, signal.SIGKILL)
            with suppress(ChildProcessError):
                os.waitpid(pid, 0)


class Isolation(enum.Enum):
    """What children may do.

    NONE: whatever the user can, in the user's folder and environment. HOME: the same, in a home
    and an environment of their own. CONFINED: in that home, and the kernel keeps them there.
    """

    NONE = enum.auto()
    HOME = enum.auto()
    CONFINED = enum.auto()


class Children:
    """The children of this process."""

    def __init__(self, isolation: Isolation, confinement: Confinement | None) -> None:
        """Prepare; `confinement` is None if they are not confined."""
        self._isolation = isolation
        self._confinement = confinement
        self._running: set[int] = set()

    def begin(self, end: int) -> int:
        """Begin the work that comes on a socket, `end`; return the process ID."""
        try:
            process = os.fork()
        except OSError:
            os.close(end)
            raise
        if not process:
            os.setsid()
            end_with_parent()
            os.dup2(end, 3, inheritable=False)
            if self._isolation is not Isolation.NONE:
                _own_streams()
            if self._confinement:
                self._confinement.close_others(4)
            else:
                os.closerange(4, MOST_DESCRIPTORS)
            self.work(socket.socket(fileno=3))
        os.close(end)
        self._running.add(process)
        return process

    def ask_place(self, process: int) -> None:
        """Let a child write its current calls."""
        if process in self._running:
            os.kill(process, signal.SIGUSR1)

    def end(self, process: int, wait_s: float = 0.0) -> int:
        """End a child and all its processes, after `wait_s`; return its exit status."""
        if process not in self._running:  # of an earlier process of the host
            return -signal.SIGKILL
        ended, status, deadline = 0, 0, time.monotonic() + wait_s
        while not ended and time.monotonic() < deadline:
            ended, status = os.waitpid(process, os.WNOHANG)
            time.sleep(0.0 if ended else 0.002)
        if not ended:
            os.kill(process, signal.SIGKILL)
            _, status = os.waitpid(process, 0)
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process, signal.SIGKILL)
        self._running.remove(process)
        if not self._confinement:
            end_orphans(self._running)
        return os.waitstatus_to_exitcode(status)

    def end_all(self) -> None:
        """End all children."""
        for process in [*self._running]:
            self.end(process)

    def work(self, end: socket.socket) -> NoReturn:
        """Run the work that comes on a socket in this process, and end it."""
        status = 1
        with suppress(BaseException):  # such as where a script has closed the socket
            channel = Channel(end, sys.maxsize)
            folder, limits, work = pickle.loads(channel.receive(math.inf))
            if self._isolation is not Isolation.NONE:
                os.chdir(folder)
                os.environ.update(dict.fromkeys(HOMES, folder))
            write_places(Path(folder))
            if hasattr(signal, 'SIGALRM'):  # a script's alarm does nothing, as over ROS
                signal.signal(signal.SIGALRM, lambda *_: None)
            home_size = limits.pop(HOME, 0)
            limit_amounts(limits)
            function = pickle.loads(work)
            if self._confinement:
                self._confinement.confine_child(Path(folder), home_size)
            channel.send(BEGUN, math.inf)
            function(channel, Path(folder))
            for stream in (sys.__stdout__, sys.__stderr__):
                if stream is not None and not stream.closed:
                    stream.flush()
            status = 0
        _exit(status)


def _own_streams() -> None:
    """Open the standard streams again: forks would share the flags of open files."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.close(stream)
        os.open(os.devnull, os.O_RDWR)  # the lowest free number
    os.close(nowhere)


def write_places(folder: Path) -> None:
    """Let this process write its current calls into a folder when asked, and when it ends."""
    file = (folder / _PLACES).open('w', encoding='utf-8')
    faulthandler.enable(file, all_threads=False)
    if hasattr(signal, 'SIGUSR1'):
        faulthandler.register(signal.SIGUSR1, file, all_threads=False)
        print('may be asked', file=file, flush=True)
    os._exit = _writing(os._exit, file)
    os.kill = _writing(os.kill, file)
    signal.raise_signal = _writing(signal.raise_signal, file)


def places_size(folder: Path) -> int:
    """Return how many bytes a process has written by `write_places`."""
    try:
        return (folder / _PLACES).lstat().st_size
    except OSError:
        return 0


def last_places(folder: Path, since: int = 0) -> list[tuple[Path, int]]:
    """Return files and lines of the calls that a process wrote last, the innermost first.

    Args:
        folder: Its folder.
        since: Earlier size of its file; skip what it wrote before.
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
    confinement = Confinement(folder) if isolation is Isolation.CONFINED else None
    getattr(importlib.import_module(module), function)()
    if isolation is not Isolation.NONE:
        os.dup2(nowhere, 2)
    has_mounts = confinement is not None and confinement.has_private_mounts
    orders.sendall(READY_WITH_MOUNTS if has_mounts else READY)
    gc.freeze()  # or else a child would touch, and so copy, the memory of all
    children = Children(isolation, confinement)
    if not FORKS:
        children.work(orders)
    while True:
        message, ends, _, _ = socket.recv_fds(orders, ORDER.size, 1)
        if not message:
            children.end_all()
            shutil.rmtree(folder, ignore_errors=True)
            _exit(0)
        order, process = ORDER.unpack(message)
        if order == BEGIN:
            orders.sendall(NUMBER.pack(_begun(children, ends)))
        elif order == PLACE:
            children.ask_place(process)
        else:
            wait_s = _WAIT_S if order == WAIT else 0.0
            orders.sendall(NUMBER.pack(children.end(process, wait_s)))


def _begun(children: Children, ends: list[int]) -> int:
    """Return the process ID of a new child; 0 if the system allows none now."""
    try:
        return children.begin(ends[0])
    except (OSError, IndexError):  # without an end, this process has too many open files
        return 0


def _orders() -> socket.socket:
    if sys.platform == 'win32':
        return socket.fromshare(sys.stdin.buffer.read())
    return socket.socket(fileno=os.dup(0))


def _writing(function: Callable[..., Any], file: IO[str]) -> Callable[..., Any]:
    def write_and_call(*args: Any) -> Any:
        faulthandler.dump_traceback(file, all_threads=False)
        return function(*args)

    return write_and_call
