"""Submissions of a class: from what was handed in to the script of each that is marked."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory

from setcmas_ctrl.laws.script_search import FUNCTIONS, same_functions
from setcmas_simu.errors import SetcmasError
from setcmas_simu.script_calls import Function
from setcmas_tools.submissions.likeness import Print, fingerprint
from setcmas_tools.submissions.notebook import MOST_SOURCE, Notebook, read_notebook, script_of
from setcmas_tools.submissions.submitted_files import (
    Files,
    Student,
    files_near,
    files_of_class,
    identity_of,
    lay_out,
    unpacked,
)

_CODE = ('.py', '.ipynb')
_SUFFIXES = (*_CODE, '.zip', '.rar', '.7z', '.tar', '.gz')
_MOST_NAMES = 5


@dataclass(frozen=True)
class Submission:
    """A student's submission.

    Attributes:
        name: Its file or folder in the class, or the name and number of its student there.
        student: Its student.
        script: Name of the script to mark; '' if there is none.
        files: The script and the files in and below its folder, by relative path.
        problem: Why there is no script to mark; '' if there is one.
        file: The file to mark; '' if there is none.
        notebook: The cells of the notebook that the script stands for; None for a script.
        is_unfilled: Whether the script is still the empty exercise.
        print: Fingerprint of its scripts.
    """

    name: str
    student: Student
    script: str = ''
    files: Mapping[str, bytes] = field(default_factory=dict)
    problem: str = ''
    file: str = ''
    notebook: Notebook | None = None
    is_unfilled: bool = False
    print: Print = frozenset()

    @contextmanager
    def unpacked(self) -> Iterator[Path]:
        """Write the files to a new folder; yield the path of the script."""
        with TemporaryDirectory(prefix='setcmas_', ignore_cleanup_errors=True) as new:
            lay_out(self.files, Path(new))
            yield Path(new, self.script)


def _read(
    name: str, student: Student, handed_in: Files, function: Function, exercise: bytes
) -> Submission:
    """Unpack the files of a submission, and choose its script."""
    files = unpacked(handed_in, name)
    notebooks = _with_scripts(files)
    script, problem = chosen_script(files, function)
    if problem:
        return Submission(name, student, problem=_naming_notebooks(problem, notebooks))
    original = next((path for path in notebooks if script_of(path) == script), script)
    neighbours = {
        path.relative_to(script.parent).as_posix(): content
        for path, content in files.items()
        if path.is_relative_to(script.parent) and isinstance(content, bytes)
    }
    sources = [content for path, content in neighbours.items() if path.endswith('.py')]
    return Submission(
        name, student, script.name, neighbours,
        file=printable(str(original)),
        notebook=notebooks.get(original),
        is_unfilled=bool(exercise) and same_functions(neighbours[script.name], exercise),
        print=fingerprint(sources),
    )  # fmt: skip


def submitted_notebook(path: Path) -> Submission:
    """Return the submission that a notebook is, with the files near it.

    Raises:
        SetcmasError: It is not a notebook, or has no law.
        OSError: It cannot be read.
    """
    own: Files = {PurePosixPath(path.name): path.read_bytes()}
    student = Student(path.name)
    read = [_read(path.name, student, own, function, b'') for function in FUNCTIONS]
    found = next((one for one in read if not one.problem), read[0])
    if found.problem:
        raise SetcmasError(found.problem)
    return replace(found, files={**files_near(path), **found.files})


def read_submissions(place: Path, function: Function, exercise: bytes = b'') -> list[Submission]:
    """Return the submissions in a folder or a zip file, sorted by students' names.

    Each script, zip file and folder is a submission, except files that Canvas or Moodle mark as
    the same student's. If there is only one folder, with several submissions, it is the class.

    Args:
        place: The folder or zip file.
        function: The function of the scripts to mark.
        exercise: Source of the exercise; empty for none.

    Raises:
        SetcmasError: There are none.
    """
    found: dict[str, tuple[Student, Files]] = {}
    for path, content in _relative_to_class(files_of_class(place), function).items():
        top, *inside = path.parts
        identity = identity_of(top)
        if not (inside or identity.group or path.suffix in _SUFFIXES):  # such as a list of names
            continue
        _, files = found.setdefault(identity.group or top, (identity.student, {}))
        files[PurePosixPath('/'.join(inside) or identity.file or top)] = content
    if not found:
        raise SetcmasError(
            f"'{place}' holds no submissions; it must be a folder or zip file with a script "
            'or folder per student'
        )
    read = [_read(printable(name), *one, function, exercise) for name, one in found.items()]
    return sorted(read, key=lambda one: (one.student.name.casefold(), one.name))


def _relative_to_class(files: Files, function: Function) -> Files:
    """Return files by path relative to the folder of the class, which may be inside another."""
    tops = {path.parts[0] for path in files}
    if len(tops) != 1 or any(identity_of(top).group for top in tops):
        return files
    inner = {
        PurePosixPath(*path.parts[1:]): content
        for path, content in files.items()
        if len(path.parts) > 1
    }
    some = {
        path.parts[0]
        for path, content in inner.items()
        if path.suffix == '.zip' or (path.suffix in _CODE and _defines(path, content, function))
    }
    is_class = len(some) > 1 or any(identity_of(path.parts[0]).group for path in inner)
    return inner if is_class else files


def _defines(path: PurePosixPath, content: bytes | str, function: Function) -> bool:
    """Return whether a script or notebook defines or assigns a function, without parsing it."""
    name = function.value
    # Lines of a notebook are within its texts; a script of Windows may begin with a mark.
    begin = r'"|\\n' if path.suffix == '.ipynb' else '^|^\ufeff'
    written = rf'(?:{begin})(?:def {name}\b|{name}\s*=[^=])'.encode()
    return isinstance(content, bytes) and bool(re.search(written, content, re.MULTILINE))


def chosen_script(files: Files, function: Function) -> tuple[PurePosixPath, str]:
    """Return the script to mark, the only one that defines the function, or why there is none."""
    sources = {
        path: content
        for path, content in files.items()
        if path.suffix == '.py' and isinstance(content, bytes)
    }
    none = PurePosixPath()
    if not sources:
        return none, _without_script(files)
    if (size := sum(map(len, sources.values()))) > MOST_SOURCE:
        limit = MOST_SOURCE // 1000
        return none, f'its Python files have {size // 1000} kB, but at most {limit} kB are allowed'
    if len(sources) == 1:  # errors are reported when it is loaded
        return next(iter(sources)), ''
    fitting = [path for path, content in sources.items() if _defines(path, content, function)]
    if not fitting:
        return none, f'none of its {len(sources)} scripts has a function {function.value}'
    if len({sources[path] for path in fitting}) > 1:  # not copies of one
        names = ' and '.join(sorted(map(str, fitting))[:_MOST_NAMES])
        each = 'both' if len(fitting) == 2 else 'all'
        return none, (
            f'{names} {each} have a function {function.value}; leave only the one to be marked in '
            'the submission'
        )
    return fitting[0], ''


def _without_script(files: Files) -> str:
    if unread := [content for content in files.values() if isinstance(content, str)]:
        return unread[0]
    names = sorted({path.name for path in files})
    if not names:
        return 'the submission is empty'
    more = f' and {len(names) - _MOST_NAMES} more' if len(names) > _MOST_NAMES else ''
    return f'no Python file, only {", ".join(names[:_MOST_NAMES])}{more}'


def _with_scripts(files: Files) -> dict[PurePosixPath, Notebook]:
    """Add the scripts of notebooks to files; return the readable notebooks."""
    found: dict[PurePosixPath, Notebook] = {}
    for path, content in [*files.items()]:
        if path.suffix != '.ipynb' or isinstance(content, str):
            continue
        try:
            found[path] = notebook = read_notebook(content)
        except SetcmasError as error:
            files[path] = f'{path.name}: {error}'
            continue
        if notebook.source.strip():
            files[script_of(path)] = notebook.source.encode(errors='replace')
    return found


def _naming_notebooks(problem: str, notebooks: Iterable[PurePosixPath]) -> str:
    """Return a problem with the names of notebooks instead of those of their scripts."""
    for path in notebooks:
        problem = problem.replace(script_of(path).name, path.name)
    return problem


def printable(name: str) -> str:
    """Return a name with the characters that a terminal would obey as escape sequences."""
    return ''.join(one if one.isprintable() else ascii(one)[1:-1] for one in name)
