"""Choice of the script of a submission that is marked."""

from __future__ import annotations

import ast
from pathlib import PurePosixPath

from setcmas_tools.submissions.notebook import MOST_SOURCE
from setcmas_tools.submissions.submitted_files import Files, Unread

_UNREADABLE = (SyntaxError, ValueError, RecursionError, MemoryError)
_MOST_NAMES = 5


def chosen_script(files: Files, function: str) -> tuple[PurePosixPath, str]:
    """Return the script to mark, or why there is none.

    It is the only script that defines the function; of several, the one that no other imports.
    Tests of a law import it too, and do not count.
    """
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
    scripts = {path: _tree(content) for path, content in sources.items()}
    fitting = [path for path, tree in scripts.items() if tree and _defines(tree, function)]
    if not fitting:
        return none, _without_function(sources, function)
    imported = {
        name for path in scripts if not _is_test(path) for name in _imports(scripts[path], path)
    }
    fitting = [path for path in fitting if path.stem not in imported] or fitting
    if len({sources[path] for path in fitting}) > 1:  # not copies of one
        names = ' and '.join(sorted(map(str, fitting))[:_MOST_NAMES])
        each = 'both' if len(fitting) == 2 else 'all'
        return none, (
            f'{names} {each} have a function {function}; leave only the one to be marked in the '
            'submission'
        )
    return fitting[0], ''


def _is_test(path: PurePosixPath) -> bool:
    return path.stem.startswith('test_') or path.stem.endswith('_test')


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


def _imports(tree: ast.Module | None, path: PurePosixPath) -> set[str]:
    """Return all parts of the names that a script imports, but for its own."""
    found = set()
    for node in ast.walk(tree) if tree else ():
        if isinstance(node, ast.ImportFrom):
            found |= {node.module or '', *(alias.name for alias in node.names)}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return {part for name in found for part in name.split('.')} - {path.stem}
