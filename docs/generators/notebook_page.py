"""A notebook as a page of the site, run while the site is built."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import nbformat
from nbclient import NotebookClient

FENCE = '```'


def text(path: Path) -> str:
    """Return the cells of a notebook and what they show."""
    notebook = nbformat.read(path, as_version=4)
    NotebookClient(notebook, timeout=300).execute()
    parts = [part for cell in notebook.cells for part in _cell(cell)]
    parts.append(f'Download [{path.name}]({path.name}).')
    return '\n\n'.join(parts)


def _cell(cell: nbformat.NotebookNode) -> Iterator[str]:
    if cell.cell_type == 'markdown':
        yield cell.source
        return
    yield f'{FENCE}python\n{cell.source}\n{FENCE}'
    for output in cell.outputs:
        yield _output(output)


def _output(output: nbformat.NotebookNode) -> str:
    data = output.get('data', {})
    if 'text/html' in data:
        return f'<div class="output">{data["text/html"]}</div>'
    if 'image/png' in data:
        return f'<img class="output" alt="plot" src="data:image/png;base64,{data["image/png"]}">'
    return f'{FENCE}text\n{output.get("text") or data.get("text/plain", "")}\n{FENCE}'
