"""Typical mistakes of students: check and grade agree, points are lost, and hints are true."""

import re
from pathlib import Path

import pytest
import yaml

from setcmas_tools import check
from setcmas_tools.grade import class_grading
from setcmas_tools.grade.grade_options import GradeOptions
from setcmas_tools.grade.marks import Student
from setcmas_tools.grade.rubric import rubric_of_exercise
from setcmas_tools.offline.kernel_confinement import obstacle
from setcmas_tools.submissions.submissions import Submission

EXERCISES = Path(__file__).parents[2] / 'data/exercises'
NAMES = ['consensus', 'ctc']


def mistakes(name):
    """Return the quick mistakes of an exercise with their scripts."""
    content = yaml.safe_load((EXERCISES / name / 'mistakes.yaml').read_text())
    for mistake in content['mistakes']:
        script = content['solution']
        for old, new in mistake['change'].items():
            assert old in script, mistake['name']
            script = script.replace(old, new)
        if mistake.get('quick'):
            yield mistake, script


def failures(marks):
    return [scenario.failure for scenario in marks.scenarios if scenario.failure]


@pytest.mark.skipif(bool(obstacle()), reason=obstacle())
@pytest.mark.parametrize('name', NAMES)
def test_check_and_grade_agree_on_a_mistake_and_the_hint_is_about_it(name, tmp_path):
    found = list(mistakes(name))
    assert found
    submissions = [
        Submission(mistake['name'], Student(mistake['name']), 'law.py', {'law.py': text.encode()})
        for mistake, text in found
    ]
    rubric = rubric_of_exercise(name)
    graded = {
        marks.student.name: marks
        for marks in class_grading.grade(submissions, rubric, tmp_path, GradeOptions(jobs=1))
    }
    for number, (mistake, text) in enumerate(found):
        script = tmp_path / f'law_{number}.py'
        script.write_text(text)
        marks = check(str(script), name).marks
        criteria = [one for scenario in marks.scenarios for one in scenario.criteria]
        hints = [one.hint for one in criteria if one.hint] + [str(one) for one in failures(marks)]
        assert marks.score == graded[mistake['name']].score < 10
        if mistake['must']:
            assert any(re.search(w, hint, re.I) for w in mistake['must'] for hint in hints), hints
        for unwanted in mistake['must_not']:
            assert not any(re.search(str(unwanted), hint, re.I) for hint in hints), hints
