"""Files of submissions: read from a folder or zip file, and unpacked, within limits."""

from __future__ import annotations

import os
import re
import stat
import zipfile
import zlib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from io import BytesIO
from pathlib import Path, PurePosixPath
from typing import IO
from unicodedata import normalize

from setcmas_simu.errors import SetcmasError

_SMALL = 1 << 20  # bytes of a file
# A notebook also holds its pictures; of a zip file, the content counts.
_LARGEST = {'.py': _SMALL, '.ipynb': 1 << 24, '.zip': 1 << 28}
_MOST_NESTED = 3  # zip files in each other
_MOST_OF_STUDENT = 1000, 1 << 24  # files and bytes
_MOST_OF_CLASS = 1 << 29  # bytes
_BLOCK = 1 << 12  # bytes that each file takes of it at least
MOST_FILES = 200
"""Files of a submission that its script finds: the newest."""
_DEEPEST, _LONGEST_PATH, _LONGEST_NAME = 50, 1000, 255  # folders, and bytes, for any file system
_IGNORED = ('__MACOSX', '__pycache__')
_BROKEN = (
    zipfile.BadZipFile, zlib.error, RuntimeError, NotImplementedError, EOFError, OSError,
    ValueError,
)  # fmt: skip
_BOUNDED = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # others unpack megabytes at a time
_NAMED_IN_UTF_8 = 0x800  # flag of a file in a zip file
_EMPTY = '.empty'
_LEFT_OUT = b'larger than 1 MB: left out\n'
# Capitals, spaces, and an ending that Windows or a browser has added, and does not show.
_ENDING = re.compile(r'(\.(?:py|ipynb|zip))(?:\.txt|\.json)?\s*$', re.IGNORECASE)

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


def files_of_class(place: Path) -> Files:
    """Return the files in a folder or a zip file; zip files among them stay packed.

    Each folder adds a path that `is_empty`; unreadable files are `Unread`.

    Raises:
        SetcmasError: It is neither folder nor zip file, or too large.
    """
    try:
        if place.is_dir():
            return _within(_in_folder(place))
        with place.open('rb') as file:
            return _packed(file)
    except _TooMuchError as error:
        raise SetcmasError(
            f"'{place}' holds more than {_MOST_OF_CLASS >> 20} MB, most of it in '{error}'; "
            'grade it in parts'
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
        return _within(_in_zip(archive))


def _within(files: Iterable[tuple[PurePosixPath, bytes]]) -> Files:
    """Return the files of a class, or raise _TooMuchError with who has handed in the most."""
    found, sizes = Files(), Counter[str]()
    for path, content in files:
        found[path] = content
        sizes[path.parts[0]] += max(len(content), _BLOCK)
        if sizes.total() > _MOST_OF_CLASS:
            raise _TooMuchError(sizes.most_common(1)[0][0])
    return found


def _in_folder(place: Path) -> Iterator[tuple[PurePosixPath, bytes]]:
    """Yield the files of a folder; folders and files that cannot be read are `Unread`."""
    refused: list[OSError] = []
    for folder, folders, names in os.walk(place, onerror=refused.append):
        here = Path(folder).relative_to(place)
        folders[:] = sorted(folders) if len(here.parts) <= _DEEPEST else []
        inside = [*(f'{name}/{_EMPTY}' for name in folders), *sorted(names)]
        yield from _read([str(here / one) for one in inside], lambda *of: _of_disk(place, *of))
    for error in refused:
        if (here := Path(error.filename).relative_to(place)) == Path():
            raise error
        reason = Unread.because(f'{here.name} cannot be read: {error.strerror}')
        yield from _read([str(here / 'all')], lambda *_, reason=reason: reason)


def _of_disk(place: Path, name: str, path: PurePosixPath) -> bytes:
    """Return the content of a file, or why it is not read."""
    try:
        status = (place / name).lstat()
        if not stat.S_ISREG(status.st_mode):
            return Unread.because(f'{path.name} is a symbolic link or no file; put a copy there')
        with (place / name).open('rb') as file:
            return _limited(file, path, status.st_size)
    except OSError as error:
        return Unread.because(f'{path.name} cannot be read: {error.strerror}')


def _in_zip(archive: zipfile.ZipFile) -> Iterator[tuple[PurePosixPath, bytes]]:
    """Yield the files of a zip file; those that cannot be read are `Unread`."""
    infos = {_name(one): one for one in archive.infolist()}

    def content(name: str, path: PurePosixPath) -> bytes:
        if infos[name].compress_type not in _BOUNDED:
            return Unread.because(f'{path.name} is compressed by an unusual method')
        try:
            with archive.open(infos[name]) as file:
                return _limited(file, path, infos[name].file_size)
        except _BROKEN:
            return Unread.because(f'{path.name} is damaged or has a password')

    return _read(sorted(infos), content)


def _name(info: zipfile.ZipInfo) -> str:
    """Return the name of a file, also where it is in UTF-8 without saying so, as of macOS."""
    name = info.filename
    if not info.flag_bits & _NAMED_IN_UTF_8:
        with suppress(UnicodeError):
            name = name.encode('cp437').decode()
    return f'{name}{_EMPTY}' if name.endswith(('/', '\\')) else name


def _limited(file: IO[bytes], path: PurePosixPath, size: int) -> bytes:
    """Return the content of a file as far as it counts."""
    most = _LARGEST.get(path.suffix)
    return _LEFT_OUT if most is None and size > _SMALL else file.read((most or _SMALL) + 1)


def _read(
    names: list[str], content: Callable[[str, PurePosixPath], bytes]
) -> Iterator[tuple[PurePosixPath, bytes]]:
    """Yield the paths of a student's files, and their content, from their names.

    A path has '/' between folders, no '..', composed accents (NFC) as Python's imports, and an
    ending in small letters without '.txt' after '.py', unless another file has that name.
    """
    taken = {*names}
    for name in names:
        folders = normalize('NFC', name.replace('\\', '/')).split('/')
        text = '/'.join(one for one in folders if one not in ('', '.', '..'))
        text = text.encode(errors='backslashreplace').decode()  # whatever bytes it has
        plain = _ENDING.sub(lambda found: found[1].lower(), text)
        path = PurePosixPath(text if plain in taken else plain)
        taken.add(str(path))
        parts = path.parts[: -1 if is_empty(path) else None]
        sizes = [len(one.encode()) for one in parts]
        if not parts or any(one in _IGNORED or one.startswith('.') for one in parts):
            continue
        if len(parts) > _DEEPEST or sum(sizes) > _LONGEST_PATH or max(sizes) > _LONGEST_NAME:
            reason = f'the path of {path.name[:_DEEPEST]} is too long'
            yield PurePosixPath(parts[0][:_DEEPEST], 'too long'), Unread.because(reason)
        elif is_empty(path):
            yield path, b''
        else:
            yield path, content(name, path)


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
    if len(content) > _LARGEST['.zip']:
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
                for each, packed in _in_zip(archive)
                for pair in _unpacked(each, packed, limit, name, nested + 1)
            ]
    except _BROKEN:
        yield path, Unread.because(f'{path.name or name} is damaged or has a password')
    else:
        for inside, read in inner or [(PurePosixPath(_EMPTY), b'')]:
            yield path / inside, read


def lay_out(files: Mapping[str, bytes], folder: Path) -> None:
    """Write files into a folder, except what it cannot hold, such as a file named as a folder."""
    for name, content in files.items():
        with suppress(OSError, ValueError):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)


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
