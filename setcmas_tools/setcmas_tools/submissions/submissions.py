"""Submissions of a class: from what was handed in to the script of each that is marked."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory

from setcmas_ctrl.laws.exercise import FUNCTIONS, UNREADABLE, same_functions
from setcmas_simu.errors import SetcmasError
from setcmas_simu.script_calls import Function
from setcmas_tools.submissions.likeness import Print, fingerprint
from setcmas_tools.submissions.notebook import MOST_SOURCE, Notebook, read_notebook, script_of
from setcmas_tools.submissions.submitted_files import (
    Files,
    Identity,
    Student,
    Unread,
    files_near,
    files_of_class,
    identity_of,
    lay_out,
    own_names,
    unpacked,
)

_CODE = ('.py', '.ipynb')
_SUFFIXES = (*_CODE, '.zip', '.rar', '.7z', '.tar', '.gz')
_MOST_NAMES = 5


@dataclass(frozen=True)
class Submission:
    """A student's submission.

    Attributes:
        name: Its file or folder, relative to the folder of the class.
        student: Its student.
        script: Name of the script to mark; '' if there is none.
        files: The script and the files in and below its folder, by relative path.
        problem: Why there is no script to mark; '' if there is one.
        file: The file to mark, relative to the folder of the class; '' if there is none.
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


@dataclass(frozen=True)
class PackedFile:
    """A file as it was handed in.

    Attributes:
        top: Its name, or that of its folder, in the folder of the class.
        path: Its path in the submission.
        content: Its content, or why it cannot be read.
        is_read: Whether it can be read.
    """

    top: str
    path: str
    content: bytes
    is_read: bool = True


@dataclass(frozen=True)
class Packed:
    """A submission as it was handed in, with zip files and notebooks as they are.

    Attributes:
        student: Its student.
        files: Its files, the newest last.
        function: The function of the script to mark.
        exercise: Source of the exercise; empty for none.
    """

    student: Student
    files: tuple[PackedFile, ...]
    function: Function
    exercise: bytes = b''


def read_submission(packed: Packed) -> Submission:
    """Unpack a submission and choose its script; those of others are read in a sandbox."""
    tops, files = dict[PurePosixPath, str](), Files()
    for top in dict.fromkeys(one.top for one in packed.files):
        own = {
            PurePosixPath(one.path): one.content if one.is_read else Unread(one.content)
            for one in packed.files
            if one.top == top
        }
        for path, content in unpacked(own, top).items():
            files[path], tops[path] = content, top  # the newest comes last
    notebooks = _with_scripts(files)
    script, problem = chosen_script(files, packed.function)
    original = next((path for path in notebooks if script_of(path) == script), script)
    top = tops.get(original, packed.files[-1].top)
    shown = printable(top)
    if problem:
        return Submission(shown, packed.student, problem=_naming_notebooks(problem, notebooks))
    neighbours = {
        path.relative_to(script.parent).as_posix(): content
        for path, content in files.items()
        if path.is_relative_to(script.parent) and not isinstance(content, Unread)
    }
    is_whole = PurePosixPath(top).suffix in _CODE
    sources = [content for name, content in neighbours.items() if name.endswith('.py')]
    return Submission(
        shown, packed.student, script.name, neighbours,
        file=shown if is_whole else printable(f'{top}/{original}'),
        notebook=notebooks.get(original),
        is_unfilled=bool(packed.exercise) and same_functions(files[script], packed.exercise),
        print=fingerprint(sources),
    )  # fmt: skip


def submitted_notebook(path: Path) -> Submission:
    """Return the submission that a notebook is, with the files near it.

    Raises:
        SetcmasError: It is not a notebook, or has no law.
        OSError: It cannot be read.
    """
    files = {PurePosixPath(path.name): path.read_bytes()}
    notebooks = _with_scripts(files)
    chosen = [chosen_script(files, function) for function in FUNCTIONS]
    script, problem = next((one for one in chosen if not one[1]), chosen[0])
    if problem:
        raise SetcmasError(_naming_notebooks(problem, notebooks))
    own = {str(one): content for one, content in files.items()}
    return Submission(
        path.name, Student(path.name), script.name, {**files_near(path), **own}, '', path.name,
        notebooks[PurePosixPath(path.name)],
    )  # fmt: skip


def find_submissions(place: Path, function: Function, exercise: bytes = b'') -> list[Packed]:
    """Return the submissions in a folder or a zip file, as they were handed in.

    Each script, zip file and folder is a submission, except files that Canvas or Moodle mark as
    the same student's. If there is only one folder, with several submissions, it is the class.

    Args:
        place: The folder or zip file.
        function: The function of the scripts to mark.
        exercise: Source of the exercise; empty for none.

    Raises:
        SetcmasError: There are none.
    """
    found: defaultdict[str, list[tuple[Identity, PackedFile]]] = defaultdict(list)
    for path, content in _relative_to_class(files_of_class(place), function).items():
        top, *inside = path.parts
        identity = identity_of(top)
        if not (inside or identity.group or path.suffix in _SUFFIXES):  # such as a list of names
            continue
        own = '/'.join(inside)
        if not inside and path.suffix != '.zip':  # what is in a zip file has paths of its own
            own = identity.file or top
        file = PackedFile(top, own, bytes(content), not isinstance(content, Unread))
        found[identity.group or top].append((identity, file))
    if not found:
        raise SetcmasError(
            f"'{place}' holds no submissions; it must be a folder or zip file with a script "
            'or folder per student'
        )
    packed: list[Packed] = []
    for parts in found.values():
        identities, files = zip(*sorted(parts, key=lambda part: part[0].number), strict=True)
        if identities[-1].number:  # of Canvas
            names = own_names([file.path for file in files])
            pairs = zip(files, names, strict=True)
            files = tuple(replace(file, path=name) for file, name in pairs)
        packed.append(Packed(identities[-1].student, files, function, exercise))
    return packed


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
        if _may_be_submission(path, content, function)
    }
    is_class = len(some) > 1 or any(identity_of(path.parts[0]).group for path in inner)
    return inner if is_class else files


def _may_be_submission(path: PurePosixPath, content: bytes, function: Function) -> bool:
    """Return whether a file may be a submission with a function, without parsing it."""
    return path.suffix == '.zip' or (path.suffix in _CODE and _mentions(content, function))


def _mentions(content: bytes, function: Function) -> bool:
    name = function.value
    written = rf'(def {name}\b|{name}\s*=)'.encode()  # also within a notebook's text
    return re.search(written, content) is not None


def chosen_script(files: Files, function: Function) -> tuple[PurePosixPath, str]:
    """Return the script to mark, the only one that defines the function, or why there is none."""
    sources = {
        path: content
        for path, content in files.items()
        if path.suffix == '.py' and not isinstance(content, Unread)
    }
    none = PurePosixPath()
    if not sources:
        return none, _without_script(files)
    if (size := sum(map(len, sources.values()))) > MOST_SOURCE:
        limit = MOST_SOURCE // 1000
        return none, f'its Python files have {size // 1000} kB, but at most {limit} kB are allowed'
    if len(sources) == 1:  # errors are reported when it is loaded
        return next(iter(sources)), ''
    fitting = [path for path, content in sources.items() if _defines(content, function)]
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
    if unread := [content for content in files.values() if isinstance(content, Unread)]:
        return unread[0].decode(errors='replace')
    names = sorted({path.name for path in files})
    if not names:
        return 'the submission is empty'
    more = f' and {len(names) - _MOST_NAMES} more' if len(names) > _MOST_NAMES else ''
    return f'no Python file, only {", ".join(names[:_MOST_NAMES])}{more}'


def _defines(source: bytes, function: Function) -> bool:
    """Return whether a script defines or assigns a function, or seems to if it is not Python."""
    try:
        tree = ast.parse(source)
    except UNREADABLE:
        return _mentions(source, function)
    for node in tree.body:
        targets = node.targets if isinstance(node, ast.Assign) else ()
        names = [one.id for one in targets if isinstance(one, ast.Name)]
        if isinstance(node, ast.FunctionDef):
            names.append(node.name)
        if function.value in names:
            return True
    return False


def _with_scripts(files: Files) -> dict[PurePosixPath, Notebook]:
    """Add the scripts of notebooks to files; return the readable notebooks."""
    found: dict[PurePosixPath, Notebook] = {}
    for path, content in [*files.items()]:
        if path.suffix != '.ipynb' or isinstance(content, Unread):
            continue
        try:
            found[path] = notebook = read_notebook(content)
        except SetcmasError as error:
            files[path] = Unread.because(f'{path.name}: {error}')
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
