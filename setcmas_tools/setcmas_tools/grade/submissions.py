"""Submissions of a class: folders and archives, the identities of their students, their laws."""

from __future__ import annotations

import ast
import os
import re
import stat
import zipfile
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path, PurePosixPath
from typing import IO

from setcmas_ctrl.scripts.script_errors import safe_text
from setcmas_simu.errors import SetcmasError
from setcmas_tools.grade.marks import Student
from setcmas_tools.grade.rubric import Rubric

_MOODLE = re.compile(r'(?P<name>.+?)_(?P<id>\d+)_assignsubmission_[a-z]+_?(?P<file>.*)')
_CANVAS = re.compile(r'(?P<name>[^_]+)_(LATE_)?(?P<id>\d+)_(?P<number>\d+)_(?P<file>.+)')
_AGAIN = re.compile(r'-\d+(?=\.\w+$)')
"""What Canvas adds to the name of a file that is handed in again."""


@dataclass(frozen=True)
class Identity:
    """Whose a file or a folder is.

    Attributes:
        student: The student.
        group: The same for all files of a submission; empty if the file is one by itself.
        number: Of several files of a name, the one with the largest number counts.
        file: What the student called the file; empty if it is not told.
    """

    student: Student
    group: str = ''
    number: int = 0
    file: str = ''


def identity_of(name: str, stem: str) -> Identity:
    """Return whose a file or a folder is.

    Moodle says 'Ada Lovelace_12345_assignsubmission_file_', with the file behind it where it makes
    no folders; Canvas says 'lovelaceada_LATE_123_4567_law-1.py'. Others are taken as they are.

    Args:
        name: The name.
        stem: The same without a file's suffix.
    """
    if found := _MOODLE.fullmatch(name):
        return Identity(_student(found['name'], found['id']), found['id'], file=found['file'])
    if found := _CANVAS.fullmatch(name):
        file = _AGAIN.sub('', found['file'])
        group = f'{found["name"]}_{found["id"]}'
        return Identity(_student(found['name'], found['id']), group, int(found['number']), file)
    return Identity(_student(stem.replace('_', ' '), stem if '@' in stem else ''))


def _student(name: str, number: str) -> Student:
    return Student(name, number, number if '@' in number else '')


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


_UNREADABLE = (SyntaxError, ValueError, RecursionError, MemoryError)
_MOST_NAMES = 5
_MOST_SOURCE = 200_000  # bytes; Python takes minutes for 1 MB of f-strings


def chosen_script(files: Files, function: str, exercise: str) -> tuple[PurePosixPath, str]:
    """Return the script that is marked, or why there is none.

    It is the one that defines the function; of several, the one that is called as the exercise is
    and that no other one imports.

    Args:
        files: The files of the submission.
        function: The function, 'control' or 'ctc'.
        exercise: Name of the exercise; empty if there is none.
    """
    sources = {path: content for path, content in files.items() if path.suffix == '.py'}
    none = PurePosixPath()
    if not sources:
        return none, _without_script(sorted({path.name for path in files}))
    if (size := sum(map(len, sources.values()))) > _MOST_SOURCE:
        limit = _MOST_SOURCE // 1000
        return none, f'its Python files have {size // 1000} kB; they must have at most {limit} kB'
    if len(sources) == 1:  # what is wrong with it is told when it is loaded
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


def _without_script(names: list[str]) -> str:
    if not names:
        return 'nothing was handed in'
    if damaged := [name for name in names if name.endswith('.zip')]:  # others are opened
        return f'{damaged[0]} is damaged or has a password'
    more = f' and {len(names) - _MOST_NAMES} more' if len(names) > _MOST_NAMES else ''
    return f'there is no Python file, only {", ".join(names[:_MOST_NAMES])}{more}'


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
_ONES = 'submission'  # folder in which autograders have that of one student
_SUFFIXES = ('.py', '.zip', '.ipynb')

_Part = tuple[str, Identity, PurePosixPath, bytes]
"""Name in the folder of the class, whose it is, path in the submission, and content of a file."""


@dataclass(frozen=True)
class Submission:
    """What a student has handed in.

    Attributes:
        name: Its file or folder, relative to the folder of the class.
        student: Whose it is.
        script: Name of the script that is marked; empty if there is none.
        files: The script and the files beside and below it, by their paths from there.
        problem: Why there is no script to mark; empty if there is one.
    """

    name: str
    student: Student
    script: str = ''
    files: Mapping[str, bytes] = field(default_factory=dict)
    problem: str = ''


def find_submissions(place: Path, rubric: Rubric) -> list[Submission]:
    """Return the submissions in a folder or a zip file, sorted by the names of students.

    Each script, zip file and folder there is one, but for the files that Canvas and Moodle say to
    be of one student. A lone folder with the scripts of several is the class itself.

    Args:
        place: The folder or the zip file.
        rubric: What they are to be marked by.

    Raises:
        SetcmasError: There are none.
    """
    found: defaultdict[str, list[_Part]] = defaultdict(list)
    for path, content in _of_class(handed_in(place), rubric.function).items():
        top = path.parts[0]
        is_file = len(path.parts) == 1
        identity = identity_of(top, path.stem if is_file else PurePosixPath(top).stem)
        if is_file and not identity.group and path.suffix not in _SUFFIXES:
            continue  # nobody's, such as a list of the class
        if is_empty(path) and is_file:
            continue
        own = PurePosixPath(identity.file or top) if is_file else path.relative_to(top)
        found[identity.group or top].append((top, identity, own, content))
    if not found:
        raise SetcmasError(
            f"'{place}' holds no submissions; it must be a folder, or a zip file, with a script "
            'or a folder of each student'
        )
    submissions = [_submission(parts, rubric) for parts in found.values()]
    return sorted(submissions, key=lambda one: (one.student.name.casefold(), one.name))


def _of_class(files: Files, function: str) -> Files:
    """Return files by their paths from the folder of the class, which may lie in another one."""
    top, *others = {path.parts[0] for path in files} or {_ONES}
    if others or top == _ONES or identity_of(top, top).group:
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
    beside = {
        path.relative_to(folder).as_posix(): content
        for path, content in files.items()
        if path.is_relative_to(folder)
    }
    return Submission(shown, student, script.name, beside)
