"""Helper modules of a control script, found by its import statements."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path


def with_helpers(file: Path) -> list[Path]:
    """Return a file, and if it is a script the modules beside it that it imports."""
    return [file, *(helper_modules(file) if file.suffix == '.py' else [])]


def helper_modules(script: Path) -> list[Path]:
    """Return the modules beside a script that it imports, and those that they import, sorted."""
    found = {script}
    waiting = [script]
    while waiting:
        new = set(_imported(waiting.pop(), script.parent)) - found
        found |= new
        waiting += new
    return sorted(found - {script})


def _imported(file: Path, folder: Path) -> Iterator[Path]:
    """Yield the files below a folder that the import statements of a file may mean."""
    try:
        statements = _import_statements(file.read_bytes())
    except (OSError, SyntaxError, ValueError):
        return  # what is wrong with it is told when it is imported
    for node in statements:
        for base, name in _names(node, file, folder):
            path = base
            for part in name.split('.'):
                path = path / part
                places = (path.with_suffix('.py'), path / '__init__.py')
                yield from (place for place in places if place.is_file())


@lru_cache(maxsize=64)
def _import_statements(source: bytes) -> list[ast.Import | ast.ImportFrom]:
    nodes = ast.walk(ast.parse(source))
    return [node for node in nodes if isinstance(node, (ast.Import, ast.ImportFrom))]


def _names(node: ast.Import | ast.ImportFrom, file: Path, folder: Path) -> list[tuple[Path, str]]:
    """Return the modules that a statement imports, and where each is looked for."""
    if isinstance(node, ast.Import):
        return [(folder, alias.name) for alias in node.names]
    base = folder
    if node.level:
        base = file.parent.joinpath(*['..'] * (node.level - 1)).resolve()
        if not base.is_relative_to(folder):
            return []
    prefix = f'{node.module}.' if node.module else ''
    return [(base, prefix + alias.name) for alias in node.names]
