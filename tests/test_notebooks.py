"""The notebooks of the pages run from their first to their last cell, and show what they say."""

from pathlib import Path

import pytest

nbclient = pytest.importorskip('nbclient')
nbformat = pytest.importorskip('nbformat')
pytest.importorskip('ipykernel')

NOTEBOOKS = sorted((Path(__file__).parents[1] / 'docs' / 'notebooks').glob('*.ipynb'))


@pytest.fixture(params=NOTEBOOKS, ids=lambda path: path.stem)
def notebook(request):
    return nbformat.read(request.param, as_version=4)


def shown(cells):
    """Return the kinds of what code cells show."""
    outputs = [output for cell in cells if cell.cell_type == 'code' for output in cell.outputs]
    return {kind for output in outputs for kind in output.get('data', {})}


def test_a_notebook_runs_and_shows_its_runs(notebook, tmp_path):
    assert [cell for cell in notebook.cells if cell.get('outputs')] == []

    resources = {'metadata': {'path': str(tmp_path)}}
    nbclient.NotebookClient(notebook, timeout=300, resources=resources).execute()

    assert {'text/html', 'image/png'} <= shown(notebook.cells)


def test_there_is_a_notebook():
    assert NOTEBOOKS
