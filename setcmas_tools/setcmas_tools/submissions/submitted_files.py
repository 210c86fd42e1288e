"""Files of submissions: read from a folder or zip file, and unpacked, within limits."""

from __future__ import annotations

import os
import stat
import zipfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from io import BytesIO
from pathlib import Path, PurePosixPath
from typing import IO

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
_LEFT_OUT = b'larger than 1 MB: left out\n'

Files = dict[PurePosixPath, bytes]


class Unread(bytes):
    """Why a file has not been read, in place of its content."""

    @classmethod
    def because(cls, reason: str) -> Unread:
        """Return the place of a file that has not been read."""
        return cls(reason.encode(errors='replace'))


class _TooMuchError(Exception):
    """Files have too many bytes, or are too many."""


class _Limit:
    """How many files and bytes may still be read."""

    def __init__(self, files: int, size: int) -> None:
        self.files, self.size = files, size

    def take(self, size: int) -> None:
        self.files, self.size = self.files - 1, self.size - size
        if self.files < 0 or self.size < 0:
            raise _TooMuchError


def is_empty(path: PurePosixPath) -> bool:
    """Return whether a path is not a file, but marks an empty folder."""
    return path.name == _EMPTY


def handed_in(place: Path) -> Files:
    """Return the files in a folder or a zip file; zip files among them stay packed.

    Each folder adds a path that `is_empty`; unreadable files are `Unread`.

    Raises:
        SetcmasError: It is neither folder nor zip file, or too large.
    """
    try:
        if place.is_dir():
            _check_not_linked(place)
            return _within(_in_folder(place))
        with place.open('rb') as file:
            return _packed(file)
    except _TooMuchError as error:
        files, size = _MOST_OF_CLASS
        raise SetcmasError(
            f"'{place}' holds more than {files:,} files or {size >> 20} MB; grade it in parts"
        ) from error
    except OSError as error:
        raise SetcmasError(f"'{place}' cannot be read: {error.strerror}") from error
    except _BROKEN as error:
        raise SetcmasError(f"'{place}' is neither a folder nor a zip file") from error


def opened_class(content: bytes) -> Files:
    """Return the files in a zip file, perhaps of a class; nothing if it cannot be read."""
    try:
        return _packed(BytesIO(content))
    except (_TooMuchError, *_BROKEN):
        return {}


def _packed(file: IO[bytes]) -> Files:
    with zipfile.ZipFile(file) as archive:
        return _within(_in_zip(archive, _largest))


def _within(files: Iterable[tuple[PurePosixPath, bytes]]) -> Files:
    """Return the files of a class within its limit."""
    limit, found = _Limit(*_MOST_OF_CLASS), Files()
    for path, content in files:
        limit.take(len(content))
        found[path] = content
    return found


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


def _largest(path: PurePosixPath, nested: int = 0) -> int:
    """Return how many bytes of a file are read; a notebook also holds its pictures."""
    if path.suffix == '.zip' and not nested:
        return _LARGEST_ZIP
    return _MOST_OF_STUDENT[1] if path.suffix in ('.zip', '.ipynb') else _LARGEST


def _is_left_out(path: PurePosixPath, size: int) -> bool:
    return size > _LARGEST and path.suffix not in ('.py', '.zip', '.ipynb')


def _in_folder(place: Path) -> Iterator[tuple[PurePosixPath, bytes]]:
    for folder, folders, names in os.walk(place):
        folders[:] = sorted(name for name in folders if _is_wanted(PurePosixPath(name)))
        for name in folders:
            yield _readable(Path(folder, name, _EMPTY).relative_to(place)), b''
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
                yield path, Unread.because(reason)
            elif _is_left_out(path, status.st_size):
                yield path, _LEFT_OUT
            else:
                with file.open('rb') as opened:
                    yield path, opened.read(_largest(path) + 1)


def _in_zip(
    archive: zipfile.ZipFile, largest: Callable[[PurePosixPath], int]
) -> Iterator[tuple[PurePosixPath, bytes]]:
    for one in sorted(archive.infolist(), key=lambda info: info.filename):
        path = PurePosixPath(one.filename)
        if not _is_wanted(path):
            continue
        if one.is_dir():
            yield path / _EMPTY, b''
        elif one.compress_type not in _BOUNDED:
            yield path, Unread.because(f'{path.name} is compressed by an unusual method')
        elif _is_left_out(path, one.file_size):
            yield path, _LEFT_OUT
        else:
            with archive.open(one) as file:
                yield path, file.read(largest(path) + 1)


def _readable(path: Path) -> PurePosixPath:
    """Return a path as writable text, whatever bytes its name has."""
    return PurePosixPath(path.as_posix().encode(errors='backslashreplace').decode())


def unpacked(files: Files, name: str) -> Files:
    """Return the files of a student with those in zip files, or why they are too much.

    A path without a name is the submission itself, which has this name.
    """
    limit = _Limit(*_MOST_OF_STUDENT)
    try:
        return {
            path: content
            for each, packed in files.items()
            for path, content in _unpacked(each, packed, limit, name)
        }
    except _TooMuchError:
        count, size = _MOST_OF_STUDENT
        return {
            PurePosixPath('all'): Unread.because(
                f'{name} has more than {count:,} files, {size >> 20} MB or {_MOST_NESTED} zip '
                'files in each other'
            )
        }


def _unpacked(
    path: PurePosixPath, content: bytes, limit: _Limit, name: str = '', nested: int = 0
) -> Iterator[tuple[PurePosixPath, bytes]]:
    """Yield a file, or the files in a readable zip file.

    Raises:
        _TooMuchError: The limit is reached.
    """
    is_zip = path.suffix == '.zip' or not path.name
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
            inner = [
                pair
                for each, packed in _in_zip(archive, lambda one: _largest(one, nested=1))
                for pair in _unpacked(each, packed, limit, name, nested + 1)
            ]
    except _BROKEN:
        yield path, Unread.because(f'{path.name or name} is damaged or has a password')
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


def files_near(script: Path) -> dict[str, bytes]:
    """Return the files in and below the folder of a script, by path relative to it.

    They are within the limits of a submission.
    """
    near: dict[str, bytes] = {}
    limit = _Limit(MOST_FILES, _MOST_OF_STUDENT[1])
    with suppress(_TooMuchError, OSError):
        for each, packed in _in_folder(script.parent):
            for path, content in _unpacked(each, packed, limit):
                if not is_empty(path) and not isinstance(content, Unread):
                    near[path.as_posix()] = content
    return near
