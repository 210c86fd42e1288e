from dataclasses import replace

import pytest

from setcmas_tools.grading.classes import kept
from setcmas_tools.grading.classes.kept import KeptMarks
from setcmas_tools.grading.classes.worker import Grader
from setcmas_tools.grading.marking import unmarked
from setcmas_tools.grading.marks import Failure, Student
from setcmas_tools.grading.rubric import rubric_of_exercise
from setcmas_tools.grading.sandbox.held import Times
from setcmas_tools.grading.submissions.found import Submission

SUBMISSION = Submission('ada', Student('ada'), 'law.py', {'law.py': b''})
LAW = 'from gains import K\ndef control(i, n, poses, t):\n    return 0, 0\n'


@pytest.fixture
def marks(tmp_path):
    """A function that opens the marks that are kept for a solution with a module beside it."""
    (tmp_path / 'law.py').write_text(LAW)
    (tmp_path / 'gains.py').write_text('K = 1\n')
    rubric = replace(rubric_of_exercise('consensus'), solution=tmp_path / 'law.py')
    grader = Grader(rubric, Times(), confined=True, folder=tmp_path)

    def opened():
        return KeptMarks(tmp_path / 'grades', grader)

    opened().keep(SUBMISSION, unmarked(rubric, 'ada', Student('ada'), Failure('late')))
    return opened


def test_marks_are_found_again(marks):
    assert marks().found(SUBMISSION).score == 0


def test_marks_do_not_count_when_a_module_of_the_solution_has_changed(marks, tmp_path):
    (tmp_path / 'gains.py').write_text('K = 2\n')

    assert marks().found(SUBMISSION) is None


def test_marks_of_another_sandbox_do_not_count(marks, monkeypatch):
    monkeypatch.setattr(kept, '_SANDBOX', 1)

    assert marks().found(SUBMISSION) is None
