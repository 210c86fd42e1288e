"""Notebooks of students, as scripts."""

import ast
import json
from unittest.mock import Mock

from setcmas_simu.script_calls import Function
from setcmas_tools import check
from setcmas_tools.submissions.notebook import in_cells, read_notebook
from setcmas_tools.submissions.submissions import read_submissions

CELLS = [
    '%matplotlib inline\n!pip install \\\n  numpy\nimport numpy as np\n'
    'from setcmas_tools import simulate, check\nfiles = !ls',
    'K = 0.5\n\ndef control(i, n, poses, t):\n    """text\n%d"""\n'
    '    return (K\n    % 2), undefined\n',
    'run = simulate(control,\n    nb_robots=5)\nK = 0.6\nrun.plot()\ncontrol(1, 2, 0, 0)\nrun',
    '%%bash\nls | wc',
    '%%time\nlaw = 1\nnp.zeros?\nif law:\n    %timeit law',
    'control = np.vectorize(control)',
]


def notebook(*cells, **known):
    sources = [{'cell_type': 'markdown', 'source': ['# Law']}]
    sources += [{'cell_type': 'code', 'source': text.splitlines(True), **known} for text in cells]
    return json.dumps({'cells': sources, 'nbformat': 4}).encode()


def test_magics_and_runs_are_left_out_and_lines_stay():
    script = read_notebook(notebook(*CELLS)).source

    compile(script, 'law', 'exec')
    assert script.splitlines()[3] == 'import numpy as np'
    assert 'def f(:' in read_notebook(notebook('%time\ndef f(:\n')).source
    for kept in ('%d"""', '    % 2)', 'K = 0.6', 'law = 1', 'control = np.vectorize(control)'):
        assert kept in script
    for left_out in ('matplotlib', 'pip', 'run', 'control(1', 'wc', '?', 'timeit'):
        assert left_out not in script


def test_a_line_of_blanks_takes_no_longer_than_its_length():
    blanks = ' ' * 190_000 + '('  # minutes if each blank is tried as the first one

    assert read_notebook(notebook(blanks)).source == f'{blanks}\n'


AGAIN = 'def control(i, n, poses, t):\n    return 0, 0'
OUTPUT = [{'output_type': 'stream', 'text': ['@'], 'data': float('nan')}]


def test_only_the_cells_of_a_notebook_count():
    whole = notebook(AGAIN, outputs=OUTPUT)
    for content in (whole.replace(b'@', b'\\ud83d'), whole.decode().encode('utf-8-sig')):
        assert read_notebook(content).source == f'{AGAIN}\n'


def test_cells_for_the_place_where_a_notebook_was_written_are_left_out():
    cells = [
        'from google.colab import drive, files\nfrom IPython.display import Image\nK = 1',
        'drive.mount("/content/drive")\nload = files.upload()\nImage("plan.png")\nprint(load)',
        AGAIN,
    ]

    assert read_notebook(notebook(*cells)).source == (
        f'pass\npass\nK = 1\npass\npass\npass\npass\n{AGAIN}\n'
    )


def test_a_large_notebook_is_not_parsed(monkeypatch):
    parse = Mock(side_effect=ast.parse)
    monkeypatch.setattr('setcmas_tools.submissions.notebook.ast.parse', parse)

    read_notebook(notebook('%time\n' * 99_999, AGAIN))
    assert not parse.called


def test_messages_name_the_cell_and_its_line():
    text = 'law_ipynb.py, line 12: NameError: undefined\n    12 | % 2), undefined'

    shown = in_cells(text, 'law.ipynb', read_notebook(notebook(*CELLS)))

    assert shown == 'law.ipynb, cell 2, line 6: NameError: undefined\n    6 | % 2), undefined'


def test_a_notebook_is_a_submission_and_cells_that_write_a_script_are_cells(tmp_path):
    (tmp_path / 'ada.ipynb').write_bytes(notebook(*CELLS[:2]))
    (tmp_path / 'bob').mkdir()
    (tmp_path / 'bob' / 'lab.ipynb').write_bytes(notebook(f'%%writefile law.py\n{CELLS[1]}'))

    ada, bob = read_submissions(tmp_path, Function.CONTROL)

    assert (ada.file, ada.script, ada.problem) == ('ada.ipynb', 'ada_ipynb.py', '')
    assert (bob.file, bob.script, bob.problem) == ('lab.ipynb', 'lab_ipynb.py', '')


RUBRIC = """\
solution: nav_wp
scenarios: [{name: short, duration: 1, criteria: [{metric: path_error, at_most: 0.1}]}]
"""
LAW = """\
import math
from gains import K
def control(i, n, poses, t):
    return (K, 0) if t < 0.5 else (unknown, 0)
check(control, 'nav_wp')
"""


def test_a_notebook_is_checked_with_the_files_near_it_and_errors_name_its_cell(tmp_path):
    (tmp_path / 'gains.py').write_text('K = 0.5\n')
    (tmp_path / 'other.py').write_text('def control(i, n, poses, t):\n    return 0, 0\n')
    (tmp_path / 'rubric.yaml').write_text(RUBRIC)
    (tmp_path / 'law.ipynb').write_bytes(notebook('from setcmas_tools import check', LAW))

    result = check(tmp_path / 'law.ipynb', tmp_path / 'rubric.yaml')

    assert result.marks.submission == 'law.ipynb'
    assert "law.ipynb, cell 2, line 4: NameError: name 'unknown'" in str(result)
    assert '_ipynb' not in str(result)

    (tmp_path / 'law.ipynb').write_bytes(notebook('K = 1', LAW.replace('gains', 'loss')))
    again = check(tmp_path / 'law.ipynb', tmp_path / 'rubric.yaml')
    assert 'law.ipynb, cell 2, line 2: ModuleNotFoundError' in str(again)
