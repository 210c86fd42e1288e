"""Confinement of a process by the kernel: files (Landlock, mounts), calls (seccomp), amounts.

Landlock has no rules for UDP before its version 10, for signals before 6, for truncation before 3,
and none for processes or for reading attributes; seccomp and private mounts fill these gaps. Two
confined processes must not exchange anything, so seccomp also forbids what shows one process to
another: threads and pipes (their numbers count up for all), the clocks and scheduling of other
processes, and futexes in shared memory.
"""

from __future__ import annotations

import ctypes
import errno
import mmap
import os
import sys
import sysconfig
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from setcmas_simu.errors import install_command

if TYPE_CHECKING:
    from landlockpy import AccessFS, Ruleset
    from pyseccomp import SyscallFilter

_LEAST_ABI = 2  # of Landlock: Linux 5.19, and Debian 12's 6.1
_FUTEX_PRIVATE = 128
_CLOCKS = 16  # from here on, clock IDs are those of other processes
_IOCTLS = (0x5401, 0x541B, 0x5421, 0x5451)
"""TCGETS, FIONREAD, FIONBIO, FIOCLEX: others could make a file immutable, for one."""
_FCNTLS = (*range(5), 1030)
"""Duplicates and flags; others, such as F_SETOWN and locks, reach other processes."""
_WRITES = (1, 2)  # O_WRONLY, O_RDWR
_TRUNCATES = 0x200
_MODE = 3 | _TRUNCATES

MEMORY = 1 << 30
"""What a submission may take of memory, in bytes."""
FILE_SIZE = 1 << 24
"""Size of a file that it may write, in bytes."""
HOME_SIZE = 1 << 26
"""What all processes of a submission may write together, in bytes."""
HOME_FILES = 1000
OPEN_FILES = 64
MOST_DESCRIPTORS = 1 << 16

_PACKAGES = ('site-packages', 'dist-packages')
_OURS = {'setcmas', 'setcmas_*', 'launch_scripts', '_setcmas*'}
_SHARED = ('/lib', '/lib64', '/usr/lib', '/usr/lib64', '/usr/local/lib', f'{sys.base_prefix}/lib')
_SINGLE = (
    '/dev/null', '/dev/zero', '/dev/random', '/dev/urandom', '/etc/ld.so.cache', '/etc/localtime',
    '/usr/share/zoneinfo',
)  # fmt: skip
_ALLOWED = """
access alarm arch_prctl brk capget chdir close close_range creat dup dup2 dup3 exit exit_group
faccessat faccessat2 fadvise64 fdatasync fstat fsync ftruncate get_mempolicy getcpu getcwd getdents
getdents64 getegid geteuid getgid getgroups getitimer getpgrp getpid getppid getrandom getresgid
getresuid getrlimit getrusage gettid gettimeofday getuid lseek lstat madvise mmap mprotect mremap
msync munmap nanosleep newfstatat pause poll ppoll pread64 preadv pselect6 pwrite64 pwritev read
readlink readlinkat readv recvfrom rename renameat renameat2 restart_syscall rseq rt_sigaction
rt_sigpending rt_sigprocmask rt_sigreturn rt_sigsuspend rt_sigtimedwait sched_get_priority_max
sched_get_priority_min sched_yield select sendto set_robust_list set_tid_address setitimer
sigaltstack stat statx time times umask uname unlink unlinkat wait4 write writev
"""
_OF_CLOCKS = 'clock_getres clock_gettime clock_nanosleep'
_OF_ITSELF = 'getpgid getsid sched_getaffinity sched_getparam sched_getscheduler'
"""Allowed for the process itself only."""
_REFUSED = """
accept bind chmod chown clone connect execve execveat fchmod fchmodat flock fork listen mkdir
mkdirat pipe pipe2 ptrace sendmsg setrlimit socket socketpair tkill truncate vfork
"""
"""Refused as such; others are 'not implemented', for which libc has another way where it can."""


def obstacle() -> str:
    """Return why submissions cannot be confined on this machine; empty if they can."""
    if sys.platform != 'linux':
        return f'{sys.platform} has no Landlock'
    try:
        import landlockpy
        import pyseccomp  # noqa: F401
    except (ImportError, RuntimeError) as error:
        return f'{error}; to fix it: {install_command("grade")} and apt-get install libseccomp2'
    try:
        abi = landlockpy.abi_version()
    except OSError:
        return 'this kernel has no Landlock'
    needed = f'{_LEAST_ABI} (Linux 5.19) is needed'
    return '' if abi >= _LEAST_ABI else f'this kernel has version {abi} of Landlock; {needed}'


def readable() -> tuple[list[Path], list[Path]]:
    """Return the files and folders that may be read, and the folders that may be listed only.

    Packages of plugins are left out like our own: the solutions of a course may be in one.
    """
    standard = {Path(sysconfig.get_path(name)).resolve() for name in ('stdlib', 'platstdlib')}
    packages = {Path(one).resolve() for one in sys.path if Path(one).name in _PACKAGES}
    hidden = {folder / name for folder in standard for name in _PACKAGES} - packages
    hidden |= {*_hidden(packages)}
    listed: list[Path] = []
    read = {path for root in standard | packages for path in _without(root, hidden, listed)}
    for root in {Path(name).resolve() for name in _SHARED}:
        inside = _without(root, {*hidden, *root.glob('python*')}, listed)
        read |= {path for path in inside if path != root}
    read |= {Path(name) for name in _SINGLE if Path(name).exists()}
    return sorted(read), sorted({*listed, *packages})


def _hidden(packages: Iterable[Path]) -> Iterator[Path]:
    """Yield the files in folders of packages that scripts must not read."""
    from importlib.metadata import distributions  # 2 MB that supervisors do not need

    entries = [entry for one in distributions() for entry in one.entry_points]
    plugins = {e.module.partition('.')[0] for e in entries if e.group.startswith('setcmas.')}
    for folder in packages:
        for name in _OURS | plugins:
            yield from folder.glob(name)
            yield from folder.glob(f'{name}.py')


def _without(folder: Path, hidden: set[Path], listed: list[Path]) -> Iterator[Path]:
    """Yield a folder, or its contents if some of them are hidden; lists such folders."""
    if folder in hidden or not os.access(folder, os.R_OK):
        return
    if not any(path.is_relative_to(folder) for path in hidden):
        yield folder
        return
    listed.append(folder)
    for inside in folder.iterdir():
        yield from _without(inside, hidden, listed)


_CLONE_NEWNS, _CLONE_NEWUSER = 0x20000, 0x10000000
_MS_BIND, _MS_REC, _MS_PRIVATE = 0x1000, 0x4000, 1 << 18
_MS_RDONLY, _HARMLESS = 1, 2 | 4 | 8  # nosuid, nodev, noexec
_MOUNT_SETATTR = 442  # on all architectures
_AT_FDCWD, _AT_RECURSIVE = -100, 0x8000
_ATTR_RDONLY = 1
_CAPABILITY_VERSION = 0x20080522
_COVERED = ('/proc', '/sys')


class PrivateMounts:
    """Mounts of a process and its children, all read-only except for a folder (Linux 5.12).

    With the system's mounts, a process sees the threads and open files of others in /proc, even
    where it must not read them; whether others have read a file, by its access time; and whether
    they have made files, by the inode numbers of its own.
    """

    def __init__(self, folder: Path) -> None:
        """Prepare; `folder` stays writable."""
        self._folder = folder
        self._libc = ctypes.CDLL(None, use_errno=True)

    @classmethod
    def are_possible(cls) -> bool:
        """Return whether the system allows them: most containers and Ubuntu 24.04 do not."""
        child = os.fork()
        if not child:
            os._exit(not cls(Path(tempfile.gettempdir()))._entered())
        return os.waitpid(child, 0)[1] == 0

    def enter(self) -> bool:
        """Move this process, which must have no threads, to them; return whether it worked."""
        # A failure half-way must not change this process.
        return hasattr(os, 'fork') and self.are_possible() and self._entered()

    def own_home(self, folder: Path, size: int) -> None:
        """Give this process a file system of its own over its folder, with the same files.

        Args:
            folder: Its folder, which becomes the current one.
            size: Bytes that may be added.
        """
        files = {file: file.read_bytes() for file in folder.rglob('*') if file.is_file()}
        size += sum(len(content) + mmap.PAGESIZE for content in files.values())
        self._call('unshare', _CLONE_NEWNS)
        most = len(files) + HOME_FILES
        self._mount('tmpfs', folder, _HARMLESS, f'size={size},nr_inodes={most},mode=0700')
        for file, content in files.items():
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(content)
        os.chdir(folder)
        header = (ctypes.c_uint32 * 2)(_CAPABILITY_VERSION)
        self._call('capset', header, (ctypes.c_uint32 * 6)())

    def _entered(self) -> bool:
        user, group = os.geteuid(), os.getegid()
        try:
            self._call('unshare', _CLONE_NEWUSER | _CLONE_NEWNS)
            Path('/proc/self/setgroups').write_text('deny')
            Path('/proc/self/uid_map').write_text(f'{user} {user} 1')
            Path('/proc/self/gid_map').write_text(f'{group} {group} 1')
            self._mount(None, Path('/'), _MS_REC | _MS_PRIVATE)
            self._mount(str(self._folder), self._folder, _MS_BIND)
            self._set_attributes(Path('/'), _ATTR_RDONLY, 0, _AT_RECURSIVE)
            self._set_attributes(self._folder, 0, _ATTR_RDONLY, 0)
            for place in _COVERED:
                self._mount('tmpfs', Path(place), _MS_RDONLY | _HARMLESS, 'size=4k,nr_inodes=1')
        except OSError:
            return False
        return True

    def _mount(self, source: str | None, target: Path, flags: int, options: str = '') -> None:
        kind = source.encode() if source else None
        flags_ = ctypes.c_ulong(flags)
        self._call('mount', kind, os.fsencode(target), kind, flags_, options.encode())

    def _set_attributes(self, target: Path, added: int, removed: int, flags: int) -> None:
        attributes = (ctypes.c_uint64 * 4)(added, removed)
        size = ctypes.c_size_t(ctypes.sizeof(attributes))
        self._call(
            'syscall', _MOUNT_SETATTR, _AT_FDCWD, os.fsencode(target), flags, attributes, size
        )

    def _call(self, name: str, *arguments: object) -> None:
        if getattr(self._libc, name)(*arguments):
            number = ctypes.get_errno()
            raise OSError(number, os.strerror(number), name)


class Confinement:
    """Confinement of the children of a process, each of which gets a folder in a common one.

    Two layers of Landlock: what all children may read, with the common folder; and a child's own
    folder. Being of different domains, children cannot trace each other either.

    Attributes:
        has_private_mounts: Whether children see neither /proc nor each other's use of files.
    """

    def __init__(self, parent: Path) -> None:
        """Prepare; `parent` is the common folder. The process must have no threads."""
        self._mounts = PrivateMounts(parent)
        self.has_private_mounts = self._mounts.enter()
        files, listed = readable()
        # The second layer only takes away, so that a few large folders do.
        self._tops = {_top(path, parent) for path in (*files, *listed)}
        self._shared = _shared_rules(files, listed, parent)
        self._filter = _call_filter()

    def close_others(self, first: int) -> None:
        """Close the open files of a child from a number on, except those of its confinement."""
        kept = self._shared.fileno()
        os.closerange(first, kept)
        os.closerange(kept + 1, MOST_DESCRIPTORS)

    def confine_child(self, folder: Path, home_size: int) -> None:
        """Confine this process, a child, for good.

        Args:
            folder: Its folder.
            home_size: How many bytes it may add to its folder.
        """
        import pyseccomp as sc
        from landlockpy import AccessFS

        if self.has_private_mounts:
            self._mounts.own_home(folder, home_size)
        with self._shared as rules:
            rules.restrict()
        read, write = _accesses()
        with _ruleset() as rules:
            for path in self._tops:
                rules.allow_path(path, read)
            rules.allow_path('/dev/null', AccessFS.READ_FILE | AccessFS.WRITE_FILE)
            rules.allow_path(folder, write)
            rules.restrict()
        own = os.getpid()
        for name in ('kill', 'tgkill'):
            _add(self._filter, sc.ALLOW, name, sc.Arg(0, sc.EQ, own))
            _add(self._filter, sc.ERRNO(errno.EPERM), name, sc.Arg(0, sc.NE, own))
        for process in (0, own):
            itself = sc.Arg(0, sc.EQ, process)
            for name in _OF_ITSELF.split():
                _add(self._filter, sc.ALLOW, name, itself)
            # asks, and sets nothing
            _add(self._filter, sc.ALLOW, 'prlimit64', itself, sc.Arg(2, sc.EQ, 0))
        self._filter.load()


def _shared_rules(files: Iterable[Path], listed: Iterable[Path], parent: Path) -> Ruleset:
    """Return the layer of Landlock that all children have."""
    from landlockpy import AccessFS

    read, write = _accesses()
    rules = _ruleset()
    for path in files:
        rules.allow_path(path, read if path.is_dir() else read & ~AccessFS.READ_DIR)
    for path in listed:
        rules.allow_path(path, AccessFS.READ_DIR)
    rules.allow_path('/dev/null', AccessFS.READ_FILE | AccessFS.WRITE_FILE)
    rules.allow_path(parent, write)
    return rules


def _ruleset() -> Ruleset:
    from landlockpy import Ruleset, Scope

    return Ruleset(scoped=Scope.SIGNAL | Scope.ABSTRACT_UNIX_SOCKET)


def _accesses() -> tuple[AccessFS, AccessFS]:
    """Return the rights on files and folders that may be read, or written."""
    from landlockpy import AccessFS

    read = AccessFS.READ_FILE | AccessFS.READ_DIR | AccessFS.EXECUTE
    write = AccessFS.WRITE_FILE | AccessFS.TRUNCATE | AccessFS.MAKE_REG | AccessFS.REMOVE_FILE
    return read, read | write


def _top(path: Path, other: Path) -> Path:
    """Return the topmost folder of a path that does not contain another path."""
    folders = (*reversed(path.parents), path)
    return next(folder for folder in folders if not other.is_relative_to(folder))


def _call_filter() -> SyscallFilter:
    """Return a filter of system calls, except those that take a process ID."""
    import pyseccomp as sc

    rules = sc.SyscallFilter(sc.ERRNO(errno.ENOSYS))
    refuse = sc.ERRNO(errno.EPERM)
    private = sc.Arg(1, sc.MASKED_EQ, _FUTEX_PRIVATE, _FUTEX_PRIVATE)
    _add(rules, sc.ALLOW, 'futex', private)
    for name in _OF_CLOCKS.split():
        _add(rules, sc.ALLOW, name, sc.Arg(0, sc.LT, _CLOCKS))
    for request in _IOCTLS:
        _add(rules, sc.ALLOW, 'ioctl', sc.Arg(1, sc.EQ, request))
    for command in _FCNTLS:
        _add(rules, sc.ALLOW, 'fcntl', sc.Arg(1, sc.EQ, command))
    # Before its version 3 (Linux 6.2) Landlock lets truncate a file that may only be read.
    for name, flags in (('open', 1), ('openat', 2)):
        _add(rules, sc.ALLOW, name, sc.Arg(flags, sc.MASKED_EQ, _TRUNCATES, 0))
        for mode in _WRITES:
            opened = sc.Arg(flags, sc.MASKED_EQ, _MODE, mode | _TRUNCATES)
            _add(rules, sc.ALLOW, name, opened)
    for name in _ALLOWED.split():
        _add(rules, sc.ALLOW, name)
    for name in _REFUSED.split():
        _add(rules, refuse, name)
    return rules


def _add(rules: SyscallFilter, action: int, name: str, *arguments: object) -> None:
    with suppress(OSError):  # this machine has no such call
        rules.add_rule(action, name, *arguments)


def limit_amounts(amounts: Mapping[str, int]) -> None:
    """Limit what this process may take, such as {'AS': bytes of memory, 'CPU': seconds}."""
    try:
        import resource
    except ImportError:  # Windows has none
        return

    for name, most in {'CORE': 0, **amounts}.items():
        with suppress(AttributeError, ValueError, OSError):  # not every system has each
            resource.setrlimit(getattr(resource, f'RLIMIT_{name}'), (most, most))
