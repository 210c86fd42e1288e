"""Files of submissions, read from folders and nested zip files within limits."""

from __future__ import annotations

import os
import stat
import zipfile
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from io import BytesIO
from pathlib import Path, PurePosixPath
from typing import IO, Any

from setcmas_simu.errors import SetcmasError

_LARGEST = 1 << 20  # bytes of a file
_MOST_NESTED = 3  # zip files in each other
_MOST_OF_STUDENT = 1000, 1 << 24  # files and bytes
_LARGEST_ZIP = 1 << 28  # bytes of a submission that is a zip file; its content counts
_MOST_OF_CLASS = 100_000, 1 << 29
MOST_FILES = 200
"""Files of a submission that its script finds: the newest."""
_LONGEST_NAME = 255  # bytes, of most file systems
_IGNORED = ('__MACOSX', '__pycache__')
_BROKEN = (zipfile.BadZipFile, RuntimeError, NotImplementedError, EOFError, OSError, ValueError)
_BOUNDED = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # others unpack megabytes at a time
_EMPTY = '.empty'

Files = dict[PurePosixPath, bytes]


class Unread(bytes):
    """Why a file has not been read, in place of its content."""


class _TooMuchError(Exception):
    """Files have too many bytes, or are too many."""


@dataclass
class _Limit:
    """How many files and bytes may still be read."""

    files: int
    size: int

    def take(self, size: int) -> None:
        self.files, self.size = self.files - 1, self.size - size
        if self.files < 0 or self.size < 0:
            raise _TooMuchError


@dataclass(frozen=True)
class _Entry:
    """A file that may be read: `read(n)` returns n bytes at most; 0 is also an unknown size."""

    path: PurePosixPath
    size: int
    read: Callable[[int], bytes]


def is_empty(path: PurePosixPath) -> bool:
    """Return whether a path is not a file, but marks an empty folder."""
    return path.name == _EMPTY


def handed_in(place: Path) -> Files:
    """Return the files in a folder or a zip file, including those of inner zip files.

    Each folder adds a path that `is_empty`; unreadable files are `Unread`.

    Raises:
        SetcmasError: It is neither folder nor zip file, or too large.
    """
    try:
        if place.is_dir():
            _check_not_linked(place)
            return _read_class(list(_in_folder(place)))
        with zipfile.ZipFile(place) as archive:
            return _read_class(list(_in_zip(archive)))
    except _TooMuchError as error:
        files, size = _MOST_OF_CLASS
        raise SetcmasError(
            f"'{place}' holds more than {files:,} files or {size >> 20} MB; grade it in parts"
        ) from error
    except OSError as error:
        raise SetcmasError(f"'{place}' cannot be read: {error.strerror}") from error
    except _BROKEN as error:
        raise SetcmasError(f"'{place}' is neither a folder nor a zip file") from error


def _check_not_linked(place: Path) -> None:
    """Check that a folder is not a copy of hard links: all its students would get no points.

    Raises:
        SetcmasError: All files of several submissions have another name.
    """
    tops: dict[Path, bool] = {}
    for file in place.rglob('*'):
        if stat.S_ISREG((status := file.lstat()).st_mode):
            top = place / file.relative_to(place).parts[0]
            tops[top] = tops.get(top, True) and status.st_nlink > 1
    if len(tops) > 1 and all(tops.values()):
        raise SetcmasError(
            f"'{place}' holds only hard links, as cp -al makes them; copy it with cp -r"
        )


def _read_class(entries: Sequence[_Entry]) -> Files:
    """Return the files of a class, of each submission within its limits."""
    prefix = PurePosixPath(os.path.commonpath([str(one.path.parent) for one in entries] or ['']))
    own: defaultdict[PurePosixPath, list[_Entry]] = defaultdict(list)
    for one in entries:
        own[PurePosixPath(*one.path.parts[: len(prefix.parts) + 1])].append(one)
    whole, files = _Limit(*_MOST_OF_CLASS), Files()
    for top, its_own in own.items():
        limit = _Limit(*_MOST_OF_STUDENT)
        try:
            found = {path: read for one in its_own for path, read in _opened(one, limit)}
        except _TooMuchError:
            count, size = _MOST_OF_STUDENT
            reason = (
                f'{top.name} has more than {count:,} files, {size >> 20} MB or {_MOST_NESTED} '
                'zip files in each other'
            )
            found = {top if its_own[0].path == top else top / 'all': _unread(reason)}
        for read in found.values():
            whole.take(len(read))
        files |= found
    return files


def _in_folder(place: Path) -> Iterator[_Entry]:
    for folder, folders, names in os.walk(place):
        folders[:] = sorted(name for name in folders if _is_wanted(PurePosixPath(name)))
        for name in folders:
            path = _readable(Path(folder, name, _EMPTY).relative_to(place))
            yield _Entry(path, 0, partial(_unread, ''))
        for name in sorted(names):
            file = Path(folder, name)
            path, status = _readable(file.relative_to(place)), file.lstat()
            if not _is_wanted(path) or not stat.S_ISREG(status.st_mode):
                continue
            if status.st_nlink > 1:  # it may be any file of the teacher's disk
                reason = (
                    f'{path.name} is a hard link, perhaps to a file of another person; check it, '
                    'and put a copy in its place'
                )
                yield _Entry(path, 0, partial(_unread, reason))
            else:
                yield _Entry(path, status.st_size, partial(_start_of, file.open, 'rb'))


def _in_zip(archive: zipfile.ZipFile) -> Iterator[_Entry]:
    for one in sorted(archive.infolist(), key=lambda info: info.filename):
        path = PurePosixPath(one.filename)
        if not _is_wanted(path):
            continue
        if one.is_dir():
            yield _Entry(path / _EMPTY, 0, partial(_unread, ''))
        elif one.compress_type in _BOUNDED:
            yield _Entry(path, one.file_size, partial(_start_of, archive.open, one))
        else:
            reason = f'{path.name} is compressed by an unusual method'
            yield _Entry(path, 0, partial(_unread, reason))


def _start_of(opened: Callable[[Any], IO[bytes]], name: Any, most: int) -> bytes:
    with opened(name) as file:
        return file.read(most)


def _unread(reason: str, _: int = 0) -> Unread:
    return Unread(reason.encode(errors='replace'))


def _readable(path: Path) -> PurePosixPath:
    """Return a path as writable text, whatever bytes its name has."""
    return PurePosixPath(path.as_posix().encode(errors='backslashreplace').decode())


def _opened(
    entry: _Entry, limit: _Limit, nested: int = 0
) -> Iterator[tuple[PurePosixPath, bytes]]:
    """Yield a file, or the files in a readable zip file.

    Raises:
        _TooMuchError: The limit is reached.
    """
    path, is_zip = entry.path, entry.path.suffix == '.zip'
    if entry.size > _LARGEST and path.suffix not in ('.py', '.zip', '.ipynb'):
        limit.take(0)
        yield path, b'larger than 1 MB: left out\n'
        return
    largest = _LARGEST
    if is_zip or path.suffix == '.ipynb':  # a notebook also holds its pictures
        largest = limit.size if nested or not is_zip else _LARGEST_ZIP
    content = entry.read(largest + 1)
    if len(content) > _LARGEST_ZIP:
        raise _TooMuchError
    limit.take(0 if is_zip and not nested else len(content))
    if not is_zip or isinstance(content, Unread):
        yield path, content
        return
    if nested == _MOST_NESTED:
        raise _TooMuchError
    try:
        with zipfile.ZipFile(BytesIO(content)) as archive:
            inner = [pair for one in _in_zip(archive) for pair in _opened(one, limit, nested + 1)]
    except _BROKEN:
        yield path, _unread(f'{path.name} is damaged or has a password')
    else:
        for inside, read in inner or [(PurePosixPath(_EMPTY), b'')]:
            yield path / inside, read


def _is_wanted(path: PurePosixPath) -> bool:
    """Return whether a path is a student's file, relative to the folder of the class."""
    return bool(path.parts) and not any(
        part in _IGNORED
        or part.startswith('.')
        or part.startswith('/')  # also '//'
        or len(part.encode(errors='replace')) > _LONGEST_NAME
        for part in path.parts
    )


def files_near(script: Path, modules: Iterable[Path]) -> dict[str, bytes]:
    """Return what a student would submit with a script, by path relative to its folder.

    These are the script and its modules, and other files in and below the folder, within the
    limits of a submission.
    """
    near = {path.relative_to(script.parent).as_posix(): path.read_bytes() for path in modules}
    limit = _Limit(MOST_FILES, _MOST_OF_STUDENT[1])
    with suppress(_TooMuchError, OSError):
        for entry in _in_folder(script.parent):
            for path, content in _opened(entry, limit):
                if not is_empty(path) and not isinstance(content, Unread):
                    near.setdefault(path.as_posix(), content)
    return near
