"""The script of a submission that is marked, among its helper modules and other files."""

from __future__ import annotations

import ast
from pathlib import PurePosixPath

from setcmas_tools.grading.submissions.handed_in import Files

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
