"""Submissions of a class: folders and archives, and their scripts."""

from __future__ import annotations

import ast
import os
import stat
import zipfile
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from io import BytesIO
from pathlib import Path, PurePosixPath
from typing import IO, Any

from setcmas_ctrl.scripts.script_errors import safe_text
from setcmas_simu.errors import SetcmasError
from setcmas_tools.grade.marks import Identity, Student, identity_of
from setcmas_tools.grade.rubric import Rubric

_LARGEST = 1 << 20  # bytes of a file
_MOST_NESTED = 3  # zip files in each other
_MOST_OF_STUDENT = 1000, 1 << 24  # files and bytes
_LARGEST_ZIP = 1 << 28  # bytes of a submission that is a zip file; its content counts
_MOST_OF_CLASS = 100_000, 1 << 29
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
    if entry.size > _LARGEST and path.suffix not in ('.py', '.zip'):
        limit.take(0)
        yield path, b'larger than 1 MB: left out\n'
        return
    largest = (limit.size if nested else _LARGEST_ZIP) if is_zip else _LARGEST
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


_UNREADABLE = (SyntaxError, ValueError, RecursionError, MemoryError)
_MOST_NAMES = 5
_MOST_SOURCE = 200_000  # bytes; Python takes minutes for 1 MB of f-strings


def chosen_script(files: Files, function: str, exercise: str) -> tuple[PurePosixPath, str]:
    """Return the script to mark, or why there is none.

    It is the script that defines the function, 'control' or 'ctc'; of several, the one that no
    other script imports, preferably with the name of the exercise.
    """
    sources = {
        path: content
        for path, content in files.items()
        if path.suffix == '.py' and not isinstance(content, Unread)
    }
    none = PurePosixPath()
    if not sources:
        return none, _without_script(files)
    if (size := sum(map(len, sources.values()))) > _MOST_SOURCE:
        limit = _MOST_SOURCE // 1000
        return none, f'its Python files have {size // 1000} kB, but at most {limit} kB are allowed'
    if len(sources) == 1:  # errors are reported when it is loaded
        return next(iter(sources)), ''
    scripts = {path: _tree(content) for path, content in sources.items()}
    fitting = [path for path, tree in scripts.items() if tree and _defines(tree, function)]
    if not fitting:
        return none, f'none of its {len(scripts)} scripts has a function {function}'
    imported = {name for tree in scripts.values() if tree for name in _imports(tree)}
    fitting = [path for path in fitting if path.stem not in imported] or fitting
    fitting = [path for path in fitting if path.stem == exercise] or fitting
    if len(fitting) > 1:
        names = ' and '.join(sorted(map(str, fitting))[:2])
        return none, f'{names} both have a function {function}; one script must have it'
    return fitting[0], ''


def _without_script(files: Files) -> str:
    if unread := [content for content in files.values() if isinstance(content, Unread)]:
        return unread[0].decode(errors='replace')
    names = sorted({path.name for path in files})
    if not names:
        return 'the submission is empty'
    more = f' and {len(names) - _MOST_NAMES} more' if len(names) > _MOST_NAMES else ''
    return f'no Python file, only {", ".join(names[:_MOST_NAMES])}{more}'


def has_function(content: bytes, function: str) -> bool:
    """Return whether a script defines a function."""
    tree = _tree(content) if len(content) <= _MOST_SOURCE else None
    return tree is not None and _defines(tree, function)


def _tree(content: bytes) -> ast.Module | None:
    try:
        return ast.parse(content)
    except _UNREADABLE:
        return None


def _defines(tree: ast.Module, function: str) -> bool:
    return any(isinstance(one, ast.FunctionDef) and one.name == function for one in tree.body)


def _imports(tree: ast.Module) -> set[str]:
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            found.add(node.module)
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return found


_MOST_FILES = 200
_OF_ONE = 'submission'  # folder in which autograders put a single student's submission
_SUFFIXES = ('.py', '.zip', '.ipynb')

_Part = tuple[str, Identity, PurePosixPath, bytes]
"""Name in the folder of the class, identity, path in the submission, and content of a file."""


@dataclass(frozen=True)
class Submission:
    """A student's submission.

    Attributes:
        name: Its file or folder, relative to the folder of the class.
        student: Its student.
        script: Name of the script to mark; '' if there is none.
        files: The script and the files in and below its folder, by relative path.
        problem: Why there is no script to mark; '' if there is one.
    """

    name: str
    student: Student
    script: str = ''
    files: Mapping[str, bytes] = field(default_factory=dict)
    problem: str = ''


def find_submissions(place: Path, rubric: Rubric) -> list[Submission]:
    """Return the submissions in a folder or a zip file, sorted by students' names.

    Each script, zip file and folder is a submission, except files that Canvas or Moodle mark as
    the same student's. A single folder with several scripts is the class itself.

    Raises:
        SetcmasError: There are none.
    """
    found: defaultdict[str, list[_Part]] = defaultdict(list)
    for path, content in _of_class(handed_in(place), rubric.function).items():
        top = path.parts[0]
        is_file = len(path.parts) == 1
        identity = identity_of(top, path.stem if is_file else PurePosixPath(top).stem)
        if is_file and not identity.group and path.suffix not in _SUFFIXES:
            continue  # no student's, such as a list of the class
        if is_empty(path) and is_file:
            continue
        own = PurePosixPath(identity.file or top) if is_file else path.relative_to(top)
        found[identity.group or top].append((top, identity, own, content))
    if not found:
        raise SetcmasError(
            f"'{place}' holds no submissions; it must be a folder or zip file with a script "
            'or folder per student'
        )
    submissions = [_submission(parts, rubric) for parts in found.values()]
    return sorted(submissions, key=lambda one: (one.student.name.casefold(), one.name))


def _of_class(files: Files, function: str) -> Files:
    """Return files by path relative to the folder of the class, which may be inside another."""
    top, *others = {path.parts[0] for path in files} or {_OF_ONE}
    if others or top == _OF_ONE or identity_of(top, top).group:
        return files
    inner = {
        PurePosixPath(*path.parts[1:]): content
        for path, content in files.items()
        if len(path.parts) > (2 if is_empty(path) else 1)
    }
    scripts = [path for path in inner if path.suffix == '.py']
    some = {path.parts[0] for path in scripts if has_function(inner[path], function)}
    if len(some) > 1 or any(identity_of(path.parts[0], '').group for path in inner):
        return inner
    deeper = _of_class(inner, function)
    return files if deeper is inner else deeper


def _submission(parts: list[_Part], rubric: Rubric) -> Submission:
    ordered = sorted(parts, key=lambda part: part[1].number)
    newest = [part for part in ordered if not is_empty(part[2])][-_MOST_FILES:]
    files: Files = {path: content for _, _, path, content in newest}
    tops = {path: top for top, _, path, _ in newest}
    last, student = ordered[-1][0], ordered[-1][1].student
    script, problem = chosen_script(files, rubric.function, rubric.exercise)
    shown = safe_text(str, tops.get(script, last))
    if problem:
        return Submission(shown, student, problem=problem)
    folder = script.parent
    neighbours = {
        path.relative_to(folder).as_posix(): content
        for path, content in files.items()
        if path.is_relative_to(folder)
    }
    return Submission(shown, student, script.name, neighbours)
