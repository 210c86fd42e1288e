"""Private mounts: a view of the file system in which processes leave no trace for each other.

Without it, a process sees the threads and open files of others in /proc, even where it must not
read them; whether others have read a file, by its access time; and whether they have made files,
by the inode numbers of its own.
"""

from __future__ import annotations

import ctypes
import os
import tempfile
from pathlib import Path

_CLONE_NEWNS, _CLONE_NEWUSER = 0x20000, 0x10000000
_MS_BIND, _MS_REC, _MS_PRIVATE = 0x1000, 0x4000, 1 << 18
_MS_RDONLY, _HARMLESS = 1, 2 | 4 | 8  # nosuid, nodev, noexec
_MOUNT_SETATTR = 442  # on all architectures
_AT_FDCWD, _AT_RECURSIVE = -100, 0x8000
_ATTR_RDONLY = 1
_CAPABILITY_VERSION = 0x20080522
_COVERED = ('/proc', '/sys')
_MORE_FILES = 1000
_PAGE = 4096


class PrivateMounts:
    """Mounts of a process and its children, all read-only except for a folder (Linux 5.12)."""

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
        return self.are_possible() and self._entered()

    def own_home(self, folder: Path, size: int) -> None:
        """Give this process a file system of its own over its folder, with the same files.

        Args:
            folder: Its folder, which becomes the current one.
            size: How many bytes may be added.
        """
        files = {file: file.read_bytes() for file in folder.rglob('*') if file.is_file()}
        size += sum(len(content) + _PAGE for content in files.values())
        self._call('unshare', _CLONE_NEWNS)
        most = len(files) + _MORE_FILES
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
