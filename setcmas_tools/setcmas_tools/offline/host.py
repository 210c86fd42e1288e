"""Host: a process that has imported all that scripts need, and forks a child for each work."""

from __future__ import annotations

import math
import mmap
import os
import pickle
import select
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

from setcmas_tools.offline.child_channel import LOOK_S, ChannelError, MachineError
from setcmas_tools.offline.fork_server import (
    BEGIN,
    FORKS,
    HOMES,
    NUMBER,
    ORDER,
    PLACE,
    READY,
    READY_WITH_MOUNTS,
    Isolation,
)
from setcmas_tools.offline.forked_child import Child, times_s
from setcmas_tools.offline.kernel_confinement import HOME_FILES, HOME_SIZE, MEMORY

_START_S = 30.0
_ANSWER_S = 60.0  # also of a machine that is overloaded
_CONTINUE_S = 0.2
_CLOSE_S = 2.0 if FORKS else 0.2
_MOST_ANSWERED = 1 << 13
# The current folder stays out of the search path, or else a file such as random.py in a student's
# folder would hide Python's own. Python 3.10 has no option for it.
_PROGRAM = (
    'import sys; del sys.path[0]; from setcmas_tools.offline import fork_server; '
    'fork_server.main()'
)
_ONE_THREAD = dict.fromkeys(
    ('OMP_NUM_THREADS', 'OPENBLAS_NUM_THREADS', 'MKL_NUM_THREADS', 'VECLIB_MAXIMUM_THREADS'), '1'
)


class Host:
    """A process that runs work with scripts in children (forks) of itself.

    A child starts in a few milliseconds, and what a script does to its process ends with it.
    Without fork (Windows), each work has a new process, and only one can run. Use as a context
    manager, which leaves no process and no file.

    Attributes:
        folder: Parent of the children's folders.
        process: The process; None before the first work.
        is_isolated: Whether children have a home of their own, of limited size.
        has_private_mounts: Whether they have private mounts; known after the first work.
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
            prepare: Function 'module:name' that imports what all children need; called once.
            isolation: What the children may do.
            environment: More environment variables.
            output: Where scripts print: nowhere, or to pipes (subprocess.PIPE).
            place: Parent of the children's folders; by default the system's temporary folder.
        """
        self._prepare = prepare
        self._isolation = isolation
        self.is_isolated = isolation is not Isolation.NONE
        self.has_private_mounts = False
        self._environment = environment or {}
        self._output = output
        self.process: subprocess.Popen[bytes] | None = None
        self.folder = Path(tempfile.mkdtemp(prefix='setcmas_', dir=place)).resolve()
        self._orders = socket.socket()
        self._children: dict[Child, tuple[int, int]] = {}  # with count and size of their files
        self._looked = 0.0
        self._most_cpu_s = math.inf

    def __enter__(self) -> Host:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    def begin(
        self,
        work: bytes,
        files: Mapping[str, bytes] | None = None,
        limits: Mapping[str, int] | None = None,
    ) -> Child:
        """Begin some work in a child; return the child, which must be ended.

        Args:
            work: A pickled function of the child's `Channel` and folder.
            files: Contents of files for the folder, by relative path.
            limits: Limits of the child's resources, such as {'AS': bytes}. The processor time,
                CPU in s, is also the limit for all isolated children together.

        Raises:
            MachineError: The process or the child does not start.
        """
        folder = Path(tempfile.mkdtemp(dir=self.folder))
        files = files or {}
        for name, content in files.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)
        self._start()
        own, process = self._forked() if FORKS else (self._orders, 0)
        most = _MOST_ANSWERED if self.is_isolated else sys.maxsize
        child = Child(self, process, folder, own, most)
        self._children[child] = len(files) + 1, sum(map(len, files.values()))
        self._most_cpu_s = (limits or {}).get('CPU', math.inf)
        child.send(pickle.dumps((str(folder), dict(limits or {}), work)), math.inf)
        return child

    def ask_place(self, process: int) -> bool:
        """Let a child write its current calls; return whether it can."""
        if FORKS:  # elsewhere a signal would kill it
            with suppress(OSError):
                self._order(PLACE, process)
        return FORKS

    def end_child(self, child: Child, order: bytes) -> int:
        """End a child and all its processes, as `Child.end`; return its exit status."""
        self._children.pop(child, None)
        if not FORKS:
            return self._stop()
        try:
            self._order(order, child.process)
            return self._answer()
        except (OSError, struct.error):
            self._stop()
            return -signal.SIGKILL

    def check_amounts(self) -> None:
        """Check what isolated children use, all together.

        Raises:
            ChannelError: It is too much.
        """
        if not self.is_isolated or time.monotonic() < self._looked + LOOK_S:
            return
        self._looked = time.monotonic()
        own = self.process.pid if self.process else 0
        memory = sum(max(0, _memory(c.process) - _memory(own)) for c in self._children)
        if memory > MEMORY:
            raise ChannelError(f'the script took more than {MEMORY >> 20} MB of memory')
        if sum(times_s(child.process)[0] for child in self._children) > self._most_cpu_s:
            raise ChannelError('the script took too much processor time')
        count = -sum(given for given, _ in self._children.values())
        size = -sum(given for _, given in self._children.values())
        for inside, _, names in os.walk(self.folder):
            count += len(names)
            for name in names:
                with suppress(OSError):
                    size += Path(inside, name).lstat().st_size
        size += sum(child.unlinked_size() for child in self._children)
        if count > HOME_FILES or size > HOME_SIZE:
            raise ChannelError(
                f'the script wrote more than {HOME_SIZE >> 20} MB or {HOME_FILES} files'
            )

    def close(self) -> None:
        """End the process with its children, and remove its folder."""
        for child in [*self._children]:
            child.end()
        self._stop()
        shutil.rmtree(self.folder, ignore_errors=True)

    def has_failed(self, child: Child) -> bool:
        """Return whether the machine, not the script, has ended a child.

        A confined script can neither end this host's process, nor its own before it begins.
        """
        has_ended = self.process is None or self.process.poll() is not None
        return self._isolation is Isolation.CONFINED and (has_ended or not child.has_begun)

    def _forked(self) -> tuple[socket.socket, int]:
        """Return the connection with a new child, and its process ID.

        If a trusted script has ended the process, it is started again, unless other children
        ended with it.

        Raises:
            MachineError: No child can start.
        """
        for _ in range(2):
            own, theirs = socket.socketpair()
            try:
                with theirs:
                    self._order(BEGIN, 0, theirs.fileno())
                process = self._answer()
            except (OSError, struct.error):
                own.close()
                self._stop()
                if self._children:
                    break
                self._start()
                continue
            if process:
                return own, process
            own.close()
            break
        raise MachineError

    def _order(self, order: bytes, process: int, *descriptors: int) -> None:
        self._continue()
        socket.send_fds(self._orders, [ORDER.pack(order, process)], descriptors)

    def _answer(self) -> int:
        """Return the number with which the process answers an order.

        Raises:
            OSError: It does not answer.
            struct.error: It has ended.
        """
        for _ in range(round(_ANSWER_S / _CONTINUE_S)):
            if select.select([self._orders], [], [], _CONTINUE_S)[0]:
                return int(NUMBER.unpack(self._orders.recv(NUMBER.size))[0])
            self._continue()
        raise TimeoutError

    def _continue(self) -> None:
        """Continue the process: a script that is not confined may stop it at any time."""
        if self.process:
            self.process.send_signal(signal.SIGCONT)

    def _start(self) -> None:
        if FORKS and self.process and self.process.poll() is None:
            return
        self._stop()
        if FORKS and self._children:  # they have ended with the process
            raise MachineError
        self._orders, theirs = socket.socketpair()
        self._orders.settimeout(_START_S)
        environment = (
            self._isolated_environment() if self.is_isolated else {**_ONE_THREAD, **os.environ}
        )
        with theirs:
            self.process = subprocess.Popen(
                [sys.executable, *(['-s'] if self.is_isolated else []), '-c', _PROGRAM,
                 str(self.folder), self._prepare, self._isolation.name],
                stdin=subprocess.PIPE if sys.platform == 'win32' else theirs.fileno(),
                stdout=self._output,
                stderr=None if self.is_isolated else self._output,  # until it is prepared
                cwd='/' if self.is_isolated else None,
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
        if ready not in (READY, READY_WITH_MOUNTS):
            raise MachineError
        self.has_private_mounts = ready == READY_WITH_MOUNTS
        self._orders.settimeout(_ANSWER_S)

    def _isolated_environment(self) -> dict[str, str]:
        """Return variables that do not identify this user.

        Neither the current folder nor the user's packages (-s), which are in the home, are
        searched: no file of a submission is imported before it is confined.
        """
        return {
            **_ONE_THREAD, **dict.fromkeys(HOMES, str(self.folder)),
            'PATH': os.defpath, 'LANG': 'C.UTF-8',
            'PYTHONPATH': os.pathsep.join(place for place in sys.path if place),
            'PYTHONDONTWRITEBYTECODE': '1',
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


def _memory(process: int) -> int:
    """Return how much memory a process has of its own, in bytes (Linux)."""
    try:
        _, resident, shared, *_ = Path(f'/proc/{process}/statm').read_text().split()
    except (OSError, ValueError):
        return 0
    return (int(resident) - int(shared)) * mmap.PAGESIZE
