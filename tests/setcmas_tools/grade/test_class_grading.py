from dataclasses import replace

import msgspec
import pytest
from sandboxes import needs_sandbox

from setcmas_ctrl.laws.script_loader import ALGORITHMS, EXERCISES
from setcmas_simu.errors import SetcmasError
from setcmas_simu.script_calls import Function
from setcmas_tools.grade import class_grading
from setcmas_tools.grade.class_grading import KEPT, Grader, KeptMarks
from setcmas_tools.grade.marking import unmarked
from setcmas_tools.grade.rubric import rubric_of_exercise
from setcmas_tools.submissions.submissions import Student, Submission, read_submissions

pytestmark = needs_sandbox

RUBRIC = rubric_of_exercise('consensus')
EXERCISE = EXERCISES.file('consensus').read_text()
GIVEN = EXERCISE.encode()
GOOD = EXERCISE.replace('pass', 'v -= K / nbRobots * (p - positions[:, j])')
SCRIPTS = {
    'good': GOOD,
    'shipped': ALGORITHMS.file('consensus').read_text(),
    'sign': GOOD.replace('v -=', 'v +='),
    'slow': GOOD.replace('K = 0.5', 'K = 0.2'),
    'unfilled': EXERCISE,
    'error': GOOD.replace('return v[0]', 'return v[9 * (t > 3)]'),
    'ended': GOOD.replace('    return', '    import os\n    t < 3 or os._exit(7)\n    return'),
}


def submissions(folder, **scripts):
    (folder / 'class').mkdir(exist_ok=True, parents=True)
    for name, source in scripts.items():
        (folder / 'class' / f'{name}.py').write_text(source)
    return read_submissions(folder / 'class', Function.CONTROL, GIVEN)


def grade(folder, scripts, **options):
    return class_grading.grade(submissions(folder, **scripts), Grader(RUBRIC), folder, **options)


def kept(folder):
    return {(file.name, file.stat().st_mtime_ns) for file in (folder / KEPT).iterdir()}


@pytest.mark.nightly
def test_grades_are_the_same_bytes_with_one_process_and_two_and_go_on_with_what_changed(tmp_path):
    one = grade(tmp_path / 'one', SCRIPTS, jobs=1)
    two = grade(tmp_path / 'two', SCRIPTS, jobs=2)

    assert msgspec.json.encode(one) == msgspec.json.encode(two)
    scores = {marks.student.name: marks.score for marks in one}
    assert scores['good'] == scores['shipped'] == RUBRIC.max_score
    assert scores['good'] > scores['slow'] > scores['sign'] == scores['unfilled'] == 0
    told = {marks.student.name: marks.scenarios[0].failure for marks in one}
    assert 'out of bounds' in told['error'].message
    assert told['ended'].message == 'the script ended its process with exit status 7'
    like = {marks.student.name: [one.submission for one in marks.similar] for marks in one}
    assert like['shipped'] == ['the built-in law consensus']
    assert like['good'] == []

    before = kept(tmp_path / 'one')
    again = grade(tmp_path / 'one', {**SCRIPTS, 'sign': SCRIPTS['slow']}, jobs=1)

    after = kept(tmp_path / 'one')
    assert len(after - before) == 1
    assert [marks.score for marks in again if marks.student.name == 'sign'] == [scores['slow']]


@pytest.mark.nightly
def test_a_grading_that_the_machine_ends_says_so(tmp_path):
    """As the kernel kills one that takes all the memory; without the sandbox, a script can."""
    two = submissions(tmp_path, kill=f'import os\nos.kill(os.getppid(), 9)\n{GOOD}', good=GOOD)

    with pytest.raises(SetcmasError, match='was killed, perhaps for lack of memory; run the same'):
        class_grading.grade(two, Grader(RUBRIC, is_confined=False), tmp_path, jobs=2)


SUBMISSION = Submission('ada', Student('ada'), 'law.py', {'law.py': b''})
LAW = 'from gains import K\ndef control(i, n, poses, t):\n    return 0, 0\n'


def test_marks_count_again_unless_a_module_of_the_solution_has_changed(tmp_path):
    (tmp_path / 'law.py').write_text(LAW)
    (tmp_path / 'gains.py').write_text('K = 1\n')
    rubric = replace(rubric_of_exercise('consensus'), solution=tmp_path / 'law.py')

    def marks():
        return KeptMarks(tmp_path / 'grades', Grader(rubric))

    marks().keep(SUBMISSION, unmarked(rubric, SUBMISSION, 'late'))
    assert marks().found(SUBMISSION).score == 0
    (tmp_path / 'gains.py').write_text('K = 2\n')
    assert marks().found(SUBMISSION) is None
