"""Confinement of a process by the kernel: files (Landlock), system calls (seccomp), amounts.

Landlock knows no UDP before its version 10 and cannot forbid processes; seccomp can. Limits on the
number of processes (RLIMIT_NPROC) do not bind root, as graders in a container are. So a confined
process may start threads, but no process, and opens no socket at all.
"""

from __future__ import annotations

import errno
import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from setcmas_simu.errors import install_command
from setcmas_tools.grade.sandbox.readable import readable

if TYPE_CHECKING:
    from pyseccomp import SyscallFilter

_LEAST_ABI = 4  # of Landlock, on which TCP is confined; Linux 6.7
_CLONE_THREAD = 0x10000
_IOCTLS = (0x5401, 0x541B, 0x5421, 0x5451)
"""TCGETS, FIONREAD, FIONBIO, FIOCLEX: others could make a file immutable, for one."""

MEMORY = 1 << 30
"""What a submission may take of memory, in bytes."""
FILE_SIZE = 1 << 24
"""Size of a file that it may write, in bytes."""
OPEN_FILES = 64

_ALLOWED = """
access alarm arch_prctl brk capget chdir clock_getres clock_gettime clock_nanosleep close
close_range creat dup dup2 dup3 epoll_create epoll_create1 epoll_ctl epoll_pwait epoll_wait
eventfd eventfd2 exit exit_group faccessat faccessat2 fadvise64 fcntl fdatasync flock fstat
fstatfs fsync ftruncate futex get_mempolicy get_robust_list getcpu getcwd getdents getdents64
getegid geteuid getgid getgroups getitimer getpgid getpgrp getpid getppid getpriority getrandom
getresgid getresuid getrlimit getrusage getsid gettid gettimeofday getuid lseek lstat
madvise mmap mprotect mremap msync munmap nanosleep newfstatat open openat pause pipe pipe2 poll
ppoll pread64 preadv pselect6 pwrite64 pwritev read readlink readlinkat readv recvfrom rename
renameat renameat2 restart_syscall rseq rt_sigaction rt_sigpending rt_sigprocmask rt_sigreturn
rt_sigsuspend rt_sigtimedwait sched_get_priority_max sched_get_priority_min sched_getaffinity
sched_getparam sched_getscheduler sched_yield select sendto set_robust_list set_tid_address
setitimer sigaltstack stat statfs statx sysinfo time times truncate umask uname unlink unlinkat
wait4 write writev
"""
_REFUSED = """
accept bind chmod chown clone connect execve execveat fchmod fchmodat fork kill listen mkdir
mkdirat ptrace sendmsg setrlimit socket socketpair tgkill tkill vfork
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
        return f'{error}: {install_command("grade")} and apt-get install libseccomp2 mend that'
    try:
        abi = landlockpy.abi_version()
    except OSError:
        return 'this kernel has no Landlock'
    needed = f'{_LEAST_ABI} (Linux 6.7) is needed'
    return '' if abi >= _LEAST_ABI else f'Landlock of this kernel is of version {abi}; {needed}'


def confine_files(folder: Path) -> None:
    """Let this process and its children write in a folder only, and read what `readable` says."""
    from landlockpy import AccessFS, Ruleset, Scope

    read = AccessFS.READ_FILE | AccessFS.READ_DIR | AccessFS.EXECUTE
    write = read | AccessFS.WRITE_FILE | AccessFS.TRUNCATE | AccessFS.MAKE_REG
    files, listed = readable()
    with Ruleset(scoped=Scope.SIGNAL | Scope.ABSTRACT_UNIX_SOCKET) as rules:
        for path in files:
            rules.allow_path(path, read if path.is_dir() else read & ~AccessFS.READ_DIR)
        for path in listed:
            rules.allow_path(path, AccessFS.READ_DIR)
        rules.allow_path('/dev/null', AccessFS.READ_FILE | AccessFS.WRITE_FILE)
        rules.allow_path(folder, write | AccessFS.REMOVE_FILE)
        rules.restrict()


def call_filter() -> SyscallFilter:
    """Return a filter of system calls, without those that name the process itself."""
    import pyseccomp as sc

    rules = sc.SyscallFilter(sc.ERRNO(errno.ENOSYS))
    refuse = sc.ERRNO(errno.EPERM)
    thread = sc.Arg(0, sc.MASKED_EQ, _CLONE_THREAD, _CLONE_THREAD)
    _add(rules, sc.ALLOW, 'clone', thread)
    _add(rules, sc.ALLOW, 'prlimit64', sc.Arg(2, sc.EQ, 0))  # asks, and sets nothing
    for request in _IOCTLS:
        _add(rules, sc.ALLOW, 'ioctl', sc.Arg(1, sc.EQ, request))
    for name in _ALLOWED.split():
        _add(rules, sc.ALLOW, name)
    for name in _REFUSED.split():
        if name not in ('clone', 'kill', 'tgkill'):
            _add(rules, refuse, name)
    _add(rules, refuse, 'clone', sc.Arg(0, sc.MASKED_EQ, _CLONE_THREAD, 0))
    return rules


def confine_calls(rules: SyscallFilter) -> None:
    """Put a filter of system calls on this process, which it cannot take off."""
    import pyseccomp as sc

    own = os.getpid()
    for name in ('kill', 'tgkill'):
        _add(rules, sc.ALLOW, name, sc.Arg(0, sc.EQ, own))
        _add(rules, sc.ERRNO(errno.EPERM), name, sc.Arg(0, sc.NE, own))
    rules.load()


def _add(rules: SyscallFilter, action: int, name: str, *arguments: object) -> None:
    with suppress(OSError):  # this machine has no such call
        rules.add_rule(action, name, *arguments)


def limit_amounts(seconds: int) -> None:
    """Limit what this process may take.

    Args:
        seconds: Processor time in s.
    """
    import resource

    amounts = {
        'AS': MEMORY, 'CPU': seconds, 'FSIZE': FILE_SIZE, 'NOFILE': OPEN_FILES, 'CORE': 0,
        'MSGQUEUE': 0, 'MEMLOCK': 0,
    }  # fmt: skip
    for name, most in amounts.items():
        with suppress(AttributeError, ValueError, OSError):  # not every system has each
            resource.setrlimit(getattr(resource, f'RLIMIT_{name}'), (most, most))
