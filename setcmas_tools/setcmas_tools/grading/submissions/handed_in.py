"""Files that a class has handed in, from a folder or a zip file, by their paths.

Nothing is followed out of the folder (links), and nothing is larger than a script may be.
"""

from __future__ import annotations

import os
import stat
import zipfile
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path, PurePosixPath
from typing import IO

from setcmas_simu.errors import SetcmasError

_LARGEST = 1 << 20  # bytes of a file
_MOST = 1 << 28  # bytes of all files of a zip file
_DIGEST = 64  # letters of the name of a file of marks
_LONGEST_NAME = 255  # bytes, of most file systems
_IGNORED = ('__MACOSX', '__pycache__')
_BROKEN = (zipfile.BadZipFile, RuntimeError, NotImplementedError, EOFError, OSError, ValueError)

KEPT = 'marks'
"""Folder of the marks of submissions, by which a folder of grades is known."""
_EMPTY = '.empty'

Files = dict[PurePosixPath, bytes]


def is_empty(path: PurePosixPath) -> bool:
    """Return whether a path is no file, but says that its folder is there."""
    return path.name == _EMPTY


def handed_in(place: Path) -> Files:
    """Return the files in a folder or a zip file, with those of zip files in it.

    Folders of grades are left out. For each folder there is a path that `is_empty`.

    Args:
        place: The folder or the zip file.

    Raises:
        SetcmasError: It is neither.
    """
    if place.is_dir():
        return dict(_in_folder(place))
    try:
        return dict(_in_zip(place.read_bytes()))
    except OSError as error:
        raise SetcmasError(f"'{place}' cannot be read: {error.strerror}") from error
    except _BROKEN as error:
        raise SetcmasError(f"'{place}' is neither a folder nor a zip file") from error


def _in_folder(place: Path) -> Iterator[tuple[PurePosixPath, bytes]]:
    for folder, folders, names in os.walk(place):
        wanted = [name for name in folders if _is_wanted(PurePosixPath(name))]
        folders[:] = sorted(name for name in wanted if not _is_of_grades(Path(folder, name)))
        for name in folders:
            yield _readable(Path(folder, name, _EMPTY).relative_to(place)), b''
        for name in sorted(names):
            file = Path(folder, name)
            path = _readable(file.relative_to(place))
            if _is_wanted(path) and stat.S_ISREG(file.lstat().st_mode):
                with file.open('rb') as content:
                    yield from _opened(path, content, _MOST)


def _is_of_grades(folder: Path) -> bool:
    return any(len(file.stem) == _DIGEST for file in (folder / KEPT).glob('*.json'))


def _readable(path: Path) -> PurePosixPath:
    """Return a path as text that can be written, whatever bytes its name has."""
    return PurePosixPath(path.as_posix().encode(errors='backslashreplace').decode())


def _in_zip(content: bytes) -> Iterator[tuple[PurePosixPath, bytes]]:
    left = _MOST
    with zipfile.ZipFile(BytesIO(content)) as archive:
        for one in sorted(archive.infolist(), key=lambda info: info.filename):
            path = PurePosixPath(one.filename)
            if not _is_wanted(path) or not left:
                continue
            if one.is_dir():
                yield path / _EMPTY, b''
                continue
            with archive.open(one) as file:
                for inside, read in _opened(path, file, left):
                    left = max(0, left - len(read))
                    yield inside, read


def _opened(
    path: PurePosixPath, file: IO[bytes], most: int
) -> Iterator[tuple[PurePosixPath, bytes]]:
    """Yield a file, or the files in it if it is a zip file that can be read."""
    is_zip = path.suffix == '.zip'
    content = file.read(min(most, _MOST if is_zip else _LARGEST + 1))
    if is_zip:
        try:
            for inside, read in list(_in_zip(content)) or [(PurePosixPath(_EMPTY), b'')]:
                yield path / inside, read
        except _BROKEN:
            yield path, b''
    elif len(content) <= _LARGEST or path.suffix == '.py':  # a script so large is told
        yield path, content
    else:
        yield path, b'larger than 1 MB: left out\n'


def _is_wanted(path: PurePosixPath) -> bool:
    """Return whether a path is one of a student's files, below the folder of the class."""
    return bool(path.parts) and not any(
        part in _IGNORED
        or part.startswith('.')
        or part == '/'
        or len(part.encode(errors='replace')) > _LONGEST_NAME
        for part in path.parts
    )
