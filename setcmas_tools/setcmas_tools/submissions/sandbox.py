"""Sandbox: a process for what students hand in, what it sees of the machine, messages with it."""

from __future__ import annotations

import math
import os
import platform
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from importlib.metadata import distributions
from importlib.util import find_spec
from pathlib import Path
from typing import IO, cast

from setcmas_simu.errors import SetcmasError
from setcmas_tools.submissions.confined_program import READY, Connection

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


@dataclass(eq=False)
class ProcessEndedError(Exception):
    """A confined process has ended or was ended.

    Attributes:
        reason: Why.
        trace: What it has written about the place where it was, which may be anything.
        was_killed: Whether something else has killed it, such as the kernel for lack of memory.
    """

    reason: str
    trace: str = ''
    was_killed: bool = False

    def __str__(self) -> str:
        return self.reason


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
            before, python, places = confining_command(), _PYTHON, _package_folders()
        return [*before, python, '-s', '-c', _PROGRAM, *places]

    def _environment(self) -> dict[str, str]:
        home = self._home or _HOME
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
        'memory, disk and number of processes sufficient? Then run the same command again'
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


_HOME = '/tmp'  # the only folder of a confined process that can be written, empty at first
_HOME_SIZE = 1 << 26  # bytes

_BASE = Path(sys.base_prefix).resolve()
_IS_OF_SYSTEM = _BASE.is_relative_to('/usr')
# In the view of a confined process.
_PYTHON = str(Path(_BASE if _IS_OF_SYSTEM else '/python', 'bin', f'python3.{sys.version_info[1]}'))

_TOP, _OURS = '/packages', '/packages/ours'
_SHARED = ('setcmas_simu', 'setcmas_ctrl', 'setcmas_expe', 'setcmas_tools')
_SOLUTIONS = ('algorithms', 'exercises', 'sessions')  # of setcmas_ctrl
_OF_PACKAGES = ('site-packages', 'dist-packages')
_OF_SYSTEM = ('/etc/ld.so.cache', '/etc/alternatives', '/etc/localtime')
_LIBRARIES = ('--symlink', 'usr/lib', '/lib', '--symlink', 'usr/lib64', '/lib64')
_DEVICES = ('/dev/null', '/dev/zero', '/dev/random', '/dev/urandom')
_FOLDERS = ('/dev', '/etc', '/proc', '/tmp', _TOP, _OURS)
_NOBODY = '65534'
_ALONE = (
    '--unshare-all', '--unshare-user', '--disable-userns', '--die-with-parent', '--new-session',
    '--cap-drop', 'ALL', '--size', str(_HOME_SIZE), '--tmpfs', _HOME, '--chdir', _HOME,
    '--remount-ro', '/',
    # Where a Python of its own has its library, which it knows by the folder outside only.
    *(() if _IS_OF_SYSTEM else ('--setenv', 'LD_LIBRARY_PATH', '/python/lib')),
)  # fmt: skip


def _package_folders() -> list[str]:
    """Return the folders of packages in the view of a confined process."""
    return [_OURS, *(f'{_TOP}/{number}' for number, _ in enumerate(_folders()))]


@cache
def confining_command() -> list[str]:
    """Return the beginning of a command that confines the program after it.

    The program sees Python, its packages, and of setcmas what scripts may import. For root, an
    outer bubblewrap arranges what only root can read, and the program is nobody: the limit of
    processes does not hold for root.
    """
    arranged = [word for words in _arranged() for word in words]
    # Where memory runs out, the kernel is to end this process first.
    first = ['choom', '-n', '1000', '--'] if shutil.which('choom') else []
    if os.geteuid():
        return [*first, 'bwrap', *arranged, *_ALONE, '--']
    tops = ['/usr', '/etc', _TOP, *([] if _IS_OF_SYSTEM else ['/python'])]
    shown = [word for name in tops for word in ('--ro-bind', name, name)]
    return [
        *first, 'bwrap', '--die-with-parent', '--unshare-pid', *arranged, '--proc', '/proc',
        '--cap-add', 'CAP_SETUID', '--cap-add', 'CAP_SETGID', '--',
        'setpriv', f'--reuid={_NOBODY}', f'--regid={_NOBODY}', '--clear-groups', '--',
        'bwrap', *shown, *_LIBRARIES, *_devices(), *_ALONE, '--',
    ]  # fmt: skip


def _arranged() -> Iterator[tuple[str, ...]]:
    """Yield options for what a confined process sees of the machine."""
    for name in _FOLDERS:
        yield '--perms', '0755', '--dir', name
    yield '--ro-bind', '/usr', '/usr'
    yield _LIBRARIES
    for name in _OF_SYSTEM:
        yield '--ro-bind-try', name, name
    yield _devices()
    for top in ('lib', 'local/lib'):
        for place in Path('/usr', top).glob('python3*/*-packages'):
            yield _hidden(str(place))
    if not _IS_OF_SYSTEM:
        yield '--ro-bind', str(_BASE), '/python'
        for place in _BASE.glob('lib/python3*/site-packages'):
            yield _hidden(f'/python/{place.relative_to(_BASE)}')
    for number, folder in enumerate(_folders()):
        yield '--ro-bind', str(folder), f'{_TOP}/{number}'
        for path in _private(folder):
            hidden = f'{_TOP}/{number}/{path.name}'
            yield _hidden(hidden) if path.is_dir() else ('--ro-bind', '/dev/null', hidden)
    for name in _SHARED:
        if (spec := find_spec(name)) and spec.origin:
            yield '--ro-bind', str(Path(spec.origin).resolve().parent), f'{_OURS}/{name}'
    for name in _SOLUTIONS:
        yield _hidden(f'{_OURS}/setcmas_ctrl/{name}')


def _hidden(place: str) -> tuple[str, ...]:
    return '--tmpfs', place, '--remount-ro', place


def _devices() -> tuple[str, ...]:
    return tuple(word for name in _DEVICES for word in ('--dev-bind', name, name))


@cache
def _folders() -> list[Path]:
    """Return the folders of installed packages."""
    found = (Path(name).resolve() for name in sys.path if Path(name).name in _OF_PACKAGES)
    return [folder for folder in dict.fromkeys(found) if folder.is_dir()]


def _private(folder: Path) -> Iterator[Path]:
    """Yield packages that scripts must not read: ours, and plugins, which may be of a course."""
    entries = [entry for one in distributions() for entry in one.entry_points]
    names = {entry.module.partition('.')[0] for entry in entries if entry.group[:8] == 'setcmas.'}
    for name in {*names, *_SHARED, 'launch_scripts'}:
        yield from (path for path in (folder / name, folder / f'{name}.py') if path.exists())


def obstacle() -> str:
    """Return why submissions cannot be confined here, and what to do; empty if they can."""
    if sys.platform != 'linux':
        return 'bubblewrap runs on Linux only; use Docker or, on Windows, WSL 2'
    if not shutil.which('bwrap'):
        packages = next((one for one in ('apt-get', 'dnf', 'zypper') if shutil.which(one)), '')
        command = f'sudo {packages} install bubblewrap' if packages else 'install bubblewrap'
        return f'bubblewrap is missing; to install it: {command}, or use Docker'
    try:
        done = subprocess.run(
            [*confining_command(), _PYTHON, '-c', ''],
            capture_output=True, text=True, errors='replace', stdin=subprocess.DEVNULL,
        )  # fmt: skip
    except OSError as error:
        return f'{error.filename} cannot be run: {error.strerror}'
    if not done.returncode:
        return ''
    reason = done.stderr.strip().rpartition('\n')[2] or f'exit status {done.returncode}'
    return f'{reason.removeprefix("bwrap: ")}; {_remedy(reason)}'


_RESTRICTED = Path('/proc/sys/kernel/apparmor_restrict_unprivileged_userns')
_PROFILE = '/usr/share/apparmor/extra-profiles/bwrap-userns-restrict'


def _remedy(reason: str) -> str:
    """Return what to do where bubblewrap cannot make namespaces."""
    if 'nknown option' in reason:
        return 'bubblewrap 0.8 or later is needed'
    if _RESTRICTED.is_file() and _RESTRICTED.read_text().strip() == '1':
        return (
            "Ubuntu's AppArmor needs its profile for bubblewrap: sudo apt-get install "
            f'apparmor-profiles && sudo install -m 644 {_PROFILE} /etc/apparmor.d/ && '
            'sudo apparmor_parser -r /etc/apparmor.d/bwrap-userns-restrict'
        )
    return (
        f'bubblewrap needs user namespaces, which Linux {platform.release()} does not allow here '
        '(sysctl user.max_user_namespaces); in Docker, add --security-opt seccomp=unconfined '
        '--security-opt apparmor=unconfined'
    )
