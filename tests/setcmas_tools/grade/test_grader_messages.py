"""Messages of a graded class: what scripts of the docs import works, and no path is shown."""

import re
import sys
import tempfile
from pathlib import Path

import pytest
from sandboxes import needs_sandbox

from setcmas_tools.grade.class_grading import Grader
from setcmas_tools.grade.rubric import rubric_of_exercise
from setcmas_tools.grade.submission_run import Times
from setcmas_tools.submissions.submissions import Submission
from setcmas_tools.submissions.submitted_files import Student

DOCS = Path(__file__).parents[3]
FOR_STUDENTS = ['README.md', *(f'docs/{name}.md' for name in (
    'tutorial', 'control_scripts', 'communication', 'notebook', 'scenarios', 'grading',
))]  # fmt: skip
IMPORT = re.compile(r'^(?:from [a-z_.]+ import [A-Za-z_, ]+|import [a-z_.]+(?: as \w+)?)$', re.M)
LAW = """
def control(robotNo, nbRobots, poses, t):
    p = poses[:2]
    v = 0.5 * (p.mean(axis=1) - p[:, robotNo - 1])
    return v[0], v[1]
"""


def shown_imports():
    texts = ((DOCS / name).read_text() for name in FOR_STUDENTS)
    return sorted({found for text in texts for found in IMPORT.findall(text)})


@pytest.fixture(scope='module')
def graded():

    def marks(source, is_confined=True):
        files = {'law.py': source.encode(), 'gains.py': b'K = 1'}
        grader = Grader(rubric_of_exercise('consensus'), Times(), is_confined)
        return grader.marks(Submission('ada', Student('ada'), 'law.py', files, file='law.py'))

    return marks


@needs_sandbox
def test_a_script_imports_what_the_docs_show_to_students(graded):
    lines = shown_imports()
    guarded = "if __name__ == '__main__':\n    print(simulate('law.py', nb_robots=8))\n"

    marks = graded('\n'.join([*lines, LAW, guarded]))

    assert 'from setcmas_tools import simulate' in lines
    assert [one.failure for one in marks.scenarios] == [None] * len(marks.scenarios)
    assert (marks.score, marks.file) == (10, 'law.py')


HEADS = {
    'setcmas itself': "raise ValueError(__import__('setcmas_tools').__file__)",
    'its own file': 'raise ValueError(__file__)',
    'a traceback': 'import traceback\ntry:\n    1 / 0\nexcept ZeroDivisionError:\n'
    '    raise ValueError(traceback.format_exc())',
    'numpy': "import numpy\nnumpy.loadtxt('none.csv')",
    'Python': 'import sys\nraise ValueError(sys.path)',
    'home': "import os\nopen(os.path.expanduser('~/none/new'))",
}


@needs_sandbox
@pytest.mark.parametrize(
    ('line', 'place'),
    [('from gains import L', '(gains.py)'), ('from numpy import L', '(numpy/__init__.py)')],
)
def test_without_the_sandbox_files_and_packages_have_no_path_either(graded, line, place):
    marks = graded(f'{line}\n{LAW}', is_confined=False)

    assert marks.scenarios[0].failure.message.splitlines()[0].endswith(place)


@needs_sandbox
@pytest.mark.parametrize('head', HEADS)
def test_no_message_shows_a_path_of_the_machine(graded, head):
    (message,) = {one.failure.message for one in graded(f'{HEADS[head]}\n{LAW}').scenarios}

    assert message.startswith('law.py, line')
    for place in (sys.prefix, f'{tempfile.gettempdir()}/setcmas_', DOCS, Path.home()):
        assert str(place) not in message
