"""Submissions of a class, and the script of each that is marked."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory

from setcmas_simu.errors import SetcmasError
from setcmas_tools.submissions.notebook import Notebook, read_notebook, script_of
from setcmas_tools.submissions.student import Identity, Student, identity_of
from setcmas_tools.submissions.submitted_files import (
    MOST_FILES,
    Files,
    Unread,
    files_near,
    handed_in,
    is_empty,
)

_UNREADABLE = (SyntaxError, ValueError, RecursionError, MemoryError)
_MOST_NAMES = 5
_MOST_SOURCE = 200_000  # bytes; Python takes minutes for 1 MB of f-strings


def chosen_script(files: Files, function: str) -> tuple[PurePosixPath, str]:
    """Return the script to mark, or why there is none.

    It is the only script that defines the function, 'control' or 'ctc'; of several, the one that
    imports all others. Tests of a law import it too, and do not count.
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
        return none, _without_function(sources, function)
    helpers = {path for one in fitting if not _is_test(one) for path in _helpers(one, scripts)}
    fitting = [path for path in fitting if path not in helpers] or fitting
    if len(fitting) > 1:
        names = ' and '.join(sorted(map(str, fitting))[:_MOST_NAMES])
        each = 'both' if len(fitting) == 2 else 'all'
        return none, (
            f'{names} {each} have a function {function}; leave only the one to be marked in the '
            'submission'
        )
    return fitting[0], ''


def _is_test(path: PurePosixPath) -> bool:
    return path.stem.startswith('test_') or path.stem.endswith('_test')


def _helpers(
    script: PurePosixPath, scripts: Mapping[PurePosixPath, ast.Module | None]
) -> set[PurePosixPath]:
    """Return the other scripts that a script imports, directly or not."""
    found, waiting = {script}, [script]
    while waiting:
        tree = scripts[waiting.pop()]
        names = _imports(tree) if tree else set()
        new = {path for path in scripts if path.stem in names} - found
        found |= new
        waiting += new
    return found - {script}


def _without_function(sources: Files, function: str) -> str:
    """Return that no script has a function, and the first syntax error if there is any."""
    text = f'none of its {len(sources)} scripts has a function {function}'
    for path, content in sources.items():
        try:
            ast.parse(content, path.name)
        except SyntaxError as error:
            return f'{text}; {path}, line {error.lineno}: {type(error).__name__}: {error.msg}'
        except _UNREADABLE:
            return f'{text}; {path} is not Python'
    return text


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
    """Return whether a script defines or assigns a function at its top level."""
    waiting: list[ast.AST] = [*tree.body]
    while waiting:
        node = waiting.pop()
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
            if node.name == function:
                return True
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            if node.id == function:
                return True
        else:
            waiting += ast.iter_child_nodes(node)
    return False


def _imports(tree: ast.Module) -> set[str]:
    """Return all parts of the names that a script imports."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            found |= {node.module or '', *(alias.name for alias in node.names)}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return {part for name in found for part in name.split('.')}


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
        notebook: The cells of the notebook that the script stands for; None for a script.
        file: The file to mark, relative to the folder of the class; '' if there is none.
    """

    name: str
    student: Student
    script: str = ''
    files: Mapping[str, bytes] = field(default_factory=dict)
    problem: str = ''
    file: str = ''
    notebook: Notebook | None = None

    @contextmanager
    def unpacked(self, parent: Path | None = None) -> Iterator[Path]:
        """Write the files to a new folder in `parent`; yield the path of the script."""
        with TemporaryDirectory(dir=parent, prefix='setcmas_', ignore_cleanup_errors=True) as new:
            for path, content in self.files.items():
                Path(new, path).parent.mkdir(parents=True, exist_ok=True)
                Path(new, path).write_bytes(content)
            yield Path(new, self.script)


def submitted_notebook(path: Path) -> Submission:
    """Return the submission that a notebook is, with the files near it.

    Raises:
        SetcmasError: It is not a notebook, or has no law.
        OSError: It cannot be read.
    """
    own = {PurePosixPath(path.name): path.read_bytes()}
    notebooks = _with_scripts(own)
    script, problem = chosen_script(own, 'control')
    if problem and not (of_condition := chosen_script(own, 'ctc'))[1]:
        script, problem = of_condition
    if problem:
        raise SetcmasError(problem.replace(script_of(PurePosixPath(path.name)).name, path.name))
    files = {**files_near(path, [path]), **{str(one): content for one, content in own.items()}}
    is_cells = script == script_of(PurePosixPath(path.name))
    notebook = notebooks[PurePosixPath(path.name)] if is_cells else None
    file = path.name if is_cells else script.name
    return Submission(path.name, Student(path.name), script.name, files, '', file, notebook)


def find_submissions(place: Path, function: str) -> list[Submission]:
    """Return the submissions in a folder or a zip file, sorted by students' names.

    Each script, zip file and folder is a submission, except files that Canvas or Moodle mark as
    the same student's. A single folder with several scripts is the class itself.

    Args:
        place: The folder or zip file.
        function: The function of the scripts to mark: 'control' or 'ctc'.

    Raises:
        SetcmasError: There are none.
    """
    found: defaultdict[str, list[_Part]] = defaultdict(list)
    for path, content in _of_class(handed_in(place), function).items():
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
    submissions = [_submission(parts, function) for parts in found.values()]
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
    scripts = {path: inner[path] for path in inner if path.suffix in ('.py', '.ipynb')}
    _with_scripts(scripts)
    some = {path.parts[0] for path, one in scripts.items() if has_function(one, function)}
    if len(some) > 1 or any(identity_of(path.parts[0], '').group for path in inner):
        return inner
    deeper = _of_class(inner, function)
    return files if deeper is inner else deeper


def _submission(parts: list[_Part], function: str) -> Submission:
    ordered = sorted(parts, key=lambda part: part[1].number)
    newest = [part for part in ordered if not is_empty(part[2])][-MOST_FILES:]
    files: Files = {path: content for _, _, path, content in newest}
    tops = {path: top for top, _, path, _ in newest}
    last, student = ordered[-1][0], ordered[-1][1].student
    notebooks = _with_scripts(files)
    script, problem = chosen_script(files, function)
    original = next((path for path in notebooks if script_of(path) == script), script)
    shown = _printable(tops.get(original, last))
    if problem:
        for path in notebooks:
            problem = problem.replace(script_of(path).name, path.name)
        return Submission(shown, student, problem=problem)
    folder = script.parent
    neighbours = {
        path.relative_to(folder).as_posix(): content
        for path, content in files.items()
        if path.is_relative_to(folder)
    }
    top = tops.get(original, last)
    file = top if PurePosixPath(top).suffix in ('.py', '.ipynb') else f'{top}/{original}'
    return Submission(
        shown, student, script.name, neighbours, file=_printable(file),
        notebook=notebooks.get(original),
    )  # fmt: skip


def _with_scripts(files: Files) -> dict[PurePosixPath, Notebook]:
    """Add the scripts of notebooks to files; return the readable notebooks."""
    found: dict[PurePosixPath, Notebook] = {}
    for path, content in [*files.items()]:
        if path.suffix != '.ipynb' or isinstance(content, Unread):
            continue
        try:
            found[path] = notebook = read_notebook(content)
        except SetcmasError as error:
            files[path] = Unread(f'{path.name}: {error}'.encode())
            continue
        for name, written in notebook.written.items():
            files.setdefault(path.with_name(name), written)
        if notebook.source.strip():
            files[script_of(path)] = notebook.source.encode(errors='replace')
    return found


def _printable(name: str) -> str:
    return ''.join(one if one.isprintable() else ascii(one)[1:-1] for one in name)
