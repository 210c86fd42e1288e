"""Submissions of a class: folders and archives, students, and scripts."""

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
"""Suffix that Canvas adds to the name of a file that is submitted again."""


@dataclass(frozen=True)
class Identity:
    """The student and the origin of a file or folder.

    Attributes:
        student: The student.
        group: Equal for all files of a submission; '' if the file is a submission by itself.
        number: Of several files with one name, the largest number counts.
        file: The student's own name of the file; '' if unknown.
    """

    student: Student
    group: str = ''
    number: int = 0
    file: str = ''


def identity_of(name: str, stem: str) -> Identity:
    """Return the identity of a file or folder.

    Moodle uses 'Ada Lovelace_12345_assignsubmission_file_', followed by the file name if it makes
    no folders; Canvas uses 'lovelaceada_LATE_123_4567_law-1.py'. Other names are used as they are.

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
"""Folder with the marks of submissions; identifies a folder of grades."""
_EMPTY = '.empty'

Files = dict[PurePosixPath, bytes]


def is_empty(path: PurePosixPath) -> bool:
    """Return whether a path is not a file, but marks an empty folder."""
    return path.name == _EMPTY


def handed_in(place: Path) -> Files:
    """Return the files in a folder or a zip file, including those of inner zip files.

    Skips folders of grades. For each folder there is a path that `is_empty`.

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
    """Return a path as writable text, whatever bytes its name has."""
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
    """Yield a file, or the files in a readable zip file."""
    is_zip = path.suffix == '.zip'
    content = file.read(min(most, _MOST if is_zip else _LARGEST + 1))
    if is_zip:
        try:
            for inside, read in list(_in_zip(content)) or [(PurePosixPath(_EMPTY), b'')]:
                yield path / inside, read
        except _BROKEN:
            yield path, b''
    elif len(content) <= _LARGEST or path.suffix == '.py':  # large scripts are reported later
        yield path, content
    else:
        yield path, b'larger than 1 MB: left out\n'


def _is_wanted(path: PurePosixPath) -> bool:
    """Return whether a path is a student's file, relative to the folder of the class."""
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
    """Return the script to mark, or why there is none.

    It is the script that defines the function; of several, the one with the name of the exercise
    that no other script imports.

    Args:
        files: The files of the submission.
        function: The function, 'control' or 'ctc'.
        exercise: Name of the exercise; '' without one.
    """
    sources = {path: content for path, content in files.items() if path.suffix == '.py'}
    none = PurePosixPath()
    if not sources:
        return none, _without_script(sorted({path.name for path in files}))
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


def _without_script(names: list[str]) -> str:
    if not names:
        return 'the submission is empty'
    if damaged := [name for name in names if name.endswith('.zip')]:  # others were opened
        return f'{damaged[0]} is damaged or has a password'
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
_ONES = 'submission'  # folder in which autograders put a single student's submission
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

    Each script, zip file and folder is a submission, except files that Canvas or Moodle name as
    one student's. A single folder with several scripts is the class itself.

    Args:
        place: The folder or the zip file.
        rubric: Rubric for the marks.

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
    neighbours = {
        path.relative_to(folder).as_posix(): content
        for path, content in files.items()
        if path.is_relative_to(folder)
    }
    return Submission(shown, student, script.name, neighbours)
