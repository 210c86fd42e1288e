"""Notebook with a law: its code cells as one script, and lines of cells in messages."""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

from setcmas_ctrl.laws.script_search import FUNCTIONS, UNREADABLE
from setcmas_simu.errors import SetcmasError

_TRANSPARENT = ('%%time', '%%capture', '%%writefile')  # the rest of the cell is ordinary code
# With the lines that a backslash joins to it; or a question for help.
_MAGIC = re.compile(
    r'^([ \t]*)(?![ \t])(?:(?:[\w., \t]+=[ \t]*[%!]|[%!?])(?:\\\n|[^\n])*|[^\n#\'"]*\?[ \t]*)$',
    re.MULTILINE,
)
_OF_JUPYTER = {'display', 'get_ipython'}
_OF_NOTEBOOKS = {'IPython', 'google', 'ipywidgets'}  # modules that need not be here
_LAWS = {one.value for one in FUNCTIONS}
MOST_SOURCE = 200_000
"""Bytes of Python of a submission; Python takes minutes for 1 MB of f-strings."""


@dataclass(frozen=True)
class Notebook:
    """Code cells of a notebook.

    Magics, shell commands and top-level statements that use setcmas_tools or call the law are
    left out; all lines keep their numbers.

    Attributes:
        cells: Source of each code cell.
    """

    cells: tuple[str, ...]

    @property
    def source(self) -> str:
        """All cells as one script."""
        return ''.join(f'{cell}\n' for cell in self.cells)

    def place(self, line: int) -> tuple[int, int]:
        """Return the code cell, from 1, and the line in it, from a line of the script."""
        for number, cell in enumerate(self.cells, 1):
            count = cell.count('\n') + 1
            if line <= count:
                return number, line
            line -= count
        return len(self.cells), line


def read_notebook(content: bytes) -> Notebook:
    """Return the code cells of a notebook, or raise SetcmasError; nothing else of it counts."""
    try:
        cells = json.loads(content)['cells']
        sources = [_source(cell) for cell in cells if cell['cell_type'] == 'code']
    except (RecursionError, KeyError, TypeError, ValueError) as error:
        raise SetcmasError('it is not a Jupyter notebook, or it is damaged') from error
    if sum(map(len, sources)) <= MOST_SOURCE:
        runs: set[str] = {*_OF_JUPYTER}
        sources = [_without_runs(_without_magics(one), runs) for one in sources]
    return Notebook(tuple(sources))


def _source(cell: Any) -> str:
    text = ''.join(cell['source'])  # a text, or a list of its lines
    text = text.encode(errors='replace').decode()  # halves of a character
    return text.replace('\r\n', '\n').replace('\r', '\n')


def _without_magics(cell: str) -> str:
    """Return a cell without its magics and shell commands, which only a cell that fails has."""
    first, _, rest = cell.partition('\n')
    if first.startswith('%%'):
        cell = f'\n{rest}' if first.split()[0] in _TRANSPARENT else '\n' * cell.count('\n')
    if _parsed(cell):
        return cell
    return _MAGIC.sub(lambda found: f'{found[1]}pass' + '\n' * found[0].count('\n'), cell)


def _parsed(cell: str) -> ast.Module | None:
    try:
        return ast.parse(cell)
    except UNREADABLE:
        return None


def _without_runs(cell: str, runs: set[str]) -> str:
    """Return a cell without its top-level statements that use names of `runs`, or Jupyter.

    The names are those that run the law, or result from it; those of the cell are added.
    """
    if not (tree := _parsed(cell)):
        return cell
    lines = cell.encode().split(b'\n')
    for node in reversed([one for one in tree.body if _is_run(one, runs)]):
        first, last = node.lineno - 1, (node.end_lineno or node.lineno) - 1
        rest = lines[last][node.end_col_offset :]
        lines[first : last + 1] = [
            lines[first][: node.col_offset] + b'pass' + (rest if first == last else b''),
            *[b''] * (last - first),
        ]
    return b'\n'.join(lines).decode()


def _is_run(node: ast.stmt, runs: set[str]) -> bool:
    """Return whether a statement runs a law, or uses the result; adds the names that it binds."""
    if isinstance(node, (ast.Import, ast.ImportFrom)):
        module = node.module if isinstance(node, ast.ImportFrom) else node.names[0].name
        package = (module or '').partition('.')[0]
        if package == 'setcmas_tools' or package in _OF_NOTEBOOKS:
            runs |= {(one.asname or one.name).partition('.')[0] for one in node.names}
        return package in _OF_NOTEBOOKS
    used = {one.id for one in ast.walk(node) if isinstance(one, ast.Name)}
    if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
        if node.name in _LAWS or used & runs:
            runs.add(node.name)
        return False
    bound = set(_bound(node))
    if not used & runs or bound & _LAWS:
        runs -= bound - _LAWS
        return False
    runs |= bound
    return True


def _bound(node: ast.stmt) -> Iterator[str]:
    for one in ast.walk(node):
        if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Store):
            yield one.id


def script_of(notebook: PurePosixPath) -> PurePosixPath:
    """Return the script that stands for a notebook."""
    return notebook.with_name(f'{notebook.stem}_ipynb.py')


def in_cells(text: str, name: str, notebook: Notebook) -> str:
    """Return a message with the notebook's name, its cells and lines, not lines of its script."""
    own = script_of(PurePosixPath(name)).name
    script = re.escape(own)

    def place(found: re.Match[str]) -> str:
        cell, line = notebook.place(int(found[2]))
        return f'{name}{found[1]}, cell {cell}, line {line}'

    def quoted(found: re.Match[str]) -> str:
        _, line = notebook.place(int(found[2]))
        return f'{found[1]}{line} | '

    if re.search(rf'{script}, line \d{{1,9}}\b', text):
        text = re.sub(r'(\n +)(\d{1,9}) \| ', quoted, text, count=1)
    text = re.sub(rf'{script}("?), line (\d{{1,9}})', place, text)
    return text.replace(own, name)
