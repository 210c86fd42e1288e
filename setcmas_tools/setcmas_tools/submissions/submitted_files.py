"""Files of submissions: whose they are, read from a folder or zip file, unpacked within limits."""

from __future__ import annotations

import os
import re
import stat
import zipfile
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from io import BytesIO
from itertools import islice
from pathlib import Path, PurePosixPath

from setcmas_simu.errors import SetcmasError

_SMALL = 1 << 20  # bytes of a file
# A notebook also holds its pictures; of a zip file, the content counts.
_LARGEST = {'.ipynb': 1 << 24, '.zip': 1 << 28}
_OF_STUDENT = 1000, 1 << 24  # files and bytes
_OF_CLASS = 100_000, 1 << 29
_LONGEST_PATH = 1000  # bytes; Python cannot remove folders that are thousands deep
_MOST_NEAR = 200  # files near a notebook
_IGNORED = ('__MACOSX', '__pycache__')
_BROKEN = (
    zipfile.BadZipFile, zlib.error, RuntimeError, NotImplementedError, EOFError, OSError,
    ValueError,
)  # fmt: skip
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
"""What platforms and computers use; a few bytes of others unpack to many before any limit."""

Files = dict[PurePosixPath, bytes | str]
"""Files by path: their content, or, as a text, why they cannot be read."""


class _TooMuchError(Exception):
    """Files have too many bytes, or are too many."""


def files_of_class(place: Path) -> Files:
    """Return the files in a folder or a zip file; zip files among them stay packed.

    Raises:
        SetcmasError: It is neither folder nor zip file, or too large.
    """
    try:
        if place.is_dir():
            return _within(_in_folder(place), *_OF_CLASS)
        with place.open('rb') as file, zipfile.ZipFile(file) as archive:
            return _within(_in_zip(archive), *_OF_CLASS)
    except _TooMuchError as error:
        most, size = _OF_CLASS
        raise SetcmasError(
            f"'{place}' holds more than {most:,} files or {size >> 20} MB; grade it in parts"
        ) from error
    except OSError as error:
        raise SetcmasError(f"'{place}' cannot be read: {error.strerror}") from error
    except _BROKEN as error:
        raise SetcmasError(f"'{place}' is neither a folder nor a zip file") from error


def unpacked(files: Files, name: str) -> Files:
    """Return the files of a submission with those in zip files, or the limit that they exceed.

    A zip file becomes a folder of its name.
    """
    try:
        return _within(_unpacked(files), *_OF_STUDENT)
    except _TooMuchError:
        most, size = _OF_STUDENT
        return {PurePosixPath('all'): f'{name} has more than {most:,} files or {size >> 20} MB'}


def _unpacked(files: Files) -> Iterator[tuple[PurePosixPath, bytes | str]]:
    for path, content in files.items():
        if path.suffix != '.zip' or isinstance(content, str):
            yield path, content
            continue
        try:
            with zipfile.ZipFile(BytesIO(content)) as archive:
                for inside, read in _in_zip(archive, is_submission=True):
                    yield path / inside, read
        except _BROKEN:
            yield path, f'{path.name} is damaged or has a password'


def _within(
    files: Iterable[tuple[PurePosixPath, bytes | str]], most: int, most_bytes: int
) -> Files:
    """Return files, or raise _TooMuchError if they are too many, or have too many bytes."""
    found, size = Files(), 0
    for path, content in files:
        found[path] = content
        size += len(content)
        if len(found) > most or size > most_bytes:
            raise _TooMuchError
    return found


def _in_folder(place: Path) -> Iterator[tuple[PurePosixPath, bytes | str]]:
    """Yield the files of a folder."""
    for folder, folders, names in os.walk(place):
        folders.sort()
        if (
            not folders
            and not names
            and (path := _cleaned_path(Path(folder).relative_to(place).as_posix()))
        ):
            yield path / 'nothing', f'the folder {path.name} is empty'
        for name in sorted(names):
            file = Path(folder, name)
            if path := _cleaned_path(file.relative_to(place).as_posix()):
                yield path, _content_of(file, path)


def _content_of(file: Path, path: PurePosixPath) -> bytes | str:
    """Return the content of a file, or why it is not read."""
    try:
        status = file.lstat()
        if not stat.S_ISREG(status.st_mode):
            return f'{path.name} is a symbolic link or no file; put a copy there'
        with file.open('rb') as opened:
            return _checked(opened.read(_largest_size(path) + 1), path)
    except OSError as error:
        return f'{path.name} cannot be read: {error.strerror}'


def _in_zip(
    archive: zipfile.ZipFile, is_submission: bool = False
) -> Iterator[tuple[PurePosixPath, bytes | str]]:
    """Yield the files of a zip file; nothing is unpacked that does not count."""
    for info in sorted(archive.infolist(), key=lambda one: one.filename):
        path = _cleaned_path(info.filename)
        if not path or info.is_dir():
            continue
        try:
            if info.compress_type not in _METHODS:
                yield path, f'{path.name} is compressed in an unusual way; zip it as "deflate"'
            elif path.suffix == '.zip' and is_submission:
                yield path, f'{path.name} is a zip file in a zip file; hand in its files'
            elif info.file_size > _largest_size(path):
                yield path, _too_large(path)
            else:
                with archive.open(info) as file:
                    yield path, _checked(file.read(_largest_size(path) + 1), path)
        except _BROKEN:
            yield path, f'{path.name} is damaged or has a password'


def _cleaned_path(name: str) -> PurePosixPath | None:
    """Return the path of a file in its submission, without '..'; None if it does not count."""
    parts = [one for one in name.replace('\\', '/').split('/') if one not in ('', '.', '..')]
    text = '/'.join(parts).encode(errors='backslashreplace').decode()  # whatever bytes it has
    is_hidden = any(one in _IGNORED or one.startswith('.') for one in parts)
    if not text or is_hidden:
        return None
    path = PurePosixPath(text)
    return path.with_suffix(path.suffix.lower())


def _largest_size(path: PurePosixPath) -> int:
    return _LARGEST.get(path.suffix, _SMALL)


def _checked(content: bytes, path: PurePosixPath) -> bytes | str:
    """Return the content of a file, or why it does not count."""
    if len(path.as_posix()) > _LONGEST_PATH:
        return f'the path of {path.name[:50]} is too long'
    if len(content) <= _largest_size(path):
        return content
    return _too_large(path)


def _too_large(path: PurePosixPath) -> str:
    return f'{path.name} is larger than {_largest_size(path) >> 20} MB'


def lay_out(files: Mapping[str, bytes], folder: Path) -> None:
    """Write files into a folder, except what it cannot hold, such as a file named as a folder."""
    for name, content in files.items():
        with suppress(OSError, ValueError):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)


def files_near(script: Path) -> dict[str, bytes]:
    """Return files in and below the folder of a script, the nearest, by path relative to it."""
    return {
        path.as_posix(): content
        for path, content in islice(_in_folder(script.parent), _MOST_NEAR)
        if path.suffix not in _LARGEST and isinstance(content, bytes)
    }


@dataclass(frozen=True)
class Student:
    """The student of a submission, as known from file names; '' for what is unknown.

    Attributes:
        name: For example 'Ada Lovelace'; may contain anything, so pages must escape it.
        id: Number or login on the learning platform.
    """

    name: str
    id: str = ''
    email: str = ''


_MOODLE = re.compile(r'(?P<name>.+?)_(?P<id>\d+)_assignsubmission_[a-z]+_?(?P<file>.*)')
_CANVAS = re.compile(
    r'(?:(?P<anonymous>anon_[^\W_]+)(?:_LATE)?|(?P<name>[^_]+)_(?:LATE_)?(?P<id>\d+))_'
    r'(?:\d+_(?P<file>.+)|(?:text|link)\.html)'
)
_HANDED_IN = re.compile(r'\.(py|ipynb|zip)$')


@dataclass(frozen=True)
class Identity:
    """The student and the origin of a file or folder.

    Attributes:
        student: The student.
        group: Equal for all files of a submission; '' if the file is a submission by itself.
        file: The student's own name of the file; '' if unknown.
    """

    student: Student
    group: str = ''
    file: str = ''


def identity_of(name: str) -> Identity:
    """Return the identity of a file or folder.

    Moodle uses 'Ada Lovelace_12345_assignsubmission_file_', followed by the file name if it makes
    no folders; Canvas uses 'lovelaceada_LATE_123_4567_law.py', or 'anon_h7KqZ_4567_law.py'.
    Other names are used as they are.
    """
    if found := _MOODLE.fullmatch(name):
        group = f'{found["name"]}_{found["id"]}'  # two students with one number stay two
        return Identity(_student(found['name'], found['id']), group, found['file'])
    if found := _CANVAS.fullmatch(name):
        student = _student(found['anonymous'] or found['name'], found['id'] or '')
        group = f'{student.name}_{student.id}'
        return Identity(student, group, found['file'] or '')
    stem = _HANDED_IN.sub('', name)
    return Identity(_student(stem.replace('_', ' '), stem if '@' in stem else ''))


def _student(name: str, number: str) -> Student:
    return Student(name, number, number if '@' in number else '')
