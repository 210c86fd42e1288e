"""What students get to check their laws: no solution, nothing hidden, the same marks."""

import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_tools import check
from setcmas_tools.grade.rubric import read_rubric, rubric_of_exercise
from setcmas_tools.grade.rubric_handout import handout

RUBRIC = """
title: A regular polygon  # SECRET comment
solution: solution.py
scenarios:
  - name: five in a ring
    nb_robots: 5
    duration: 30
    criteria:
      - {name: SECRET one, metric: path_error, at_most: 1, hidden: true}
      - {name: shape, metric: path_ratio, between: [0.5, 1.5], points: 3, needs: SECRET one}
      - {name: places, metric: end_error, at_most: 0.05, points: 3}
      - {name: paths, metric: path_error, at_most: 0, none_at: 5, points: 3, needs: shape}
  - name: SECRET scenario
    hidden: true
    nb_robots: 3
    duration: 10
    criteria: [{metric: path_error, at_most: 1}]
"""
SOLUTION = """
import numpy as np
from SECRET_gains import K
def control(robotNo, nbRobots, poses, t):
    angle = 2 * np.pi * robotNo / nbRobots
    return tuple(K * (2 * np.array([np.cos(angle), np.sin(angle)]) - poses[:2, robotNo - 1]))
"""
LAW = SOLUTION.replace('from SECRET_gains import K', 'K = 0.5')


@pytest.fixture
def rubric(tmp_path):
    """The file of a rubric with its solution."""
    files = {'final.yaml': RUBRIC, 'solution.py': SOLUTION, 'SECRET_gains.py': 'K = 0.5\n'}
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    return tmp_path / 'final.yaml'


def unpacked(rubric, folder):
    for path, content in handout(read_rubric(rubric)).items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_bytes(content)
    return folder / rubric.name


def test_students_check_without_the_solution_and_get_the_same_marks(rubric, tmp_path):
    theirs = unpacked(rubric, tmp_path / 'theirs')
    content = {path: path.read_bytes() for path in theirs.parent.rglob('*') if path.is_file()}
    laws = {'right': LAW, 'next': LAW.replace('* robotNo /', '* (robotNo + 1) /')}

    for path, data in content.items():
        assert 'SECRET' not in path.name
        assert b'SECRET' not in data
        assert b'import' not in data
    points = {}
    for name, text in laws.items():
        (tmp_path / f'{name}.py').write_text(text)
        own, full = (check(tmp_path / f'{name}.py', one) for one in (theirs, rubric))
        assert own.marks.score == full.marks.score
        assert own.hidden_points == full.hidden_points == 2
        assert str(own).endswith('; 2 more are for hidden parts, which setcmas grade marks')
        points[name] = [one.points for one in own.marks.scenarios[0].criteria]
    assert points['right'] == [3, 3, 3]
    assert points['next'][:2] == [3, 0]  # one place further, the polygon is as regular


@pytest.mark.parametrize('exercise', ['consensus', 'point_ahead', 'ctc'])
def test_a_solution_that_students_have_anyway_stays(tmp_path, exercise):
    rubric = rubric_of_exercise(exercise)
    theirs = unpacked(rubric.file, tmp_path / 'theirs')

    assert read_rubric(theirs).solution == rubric.solution
    assert read_rubric(theirs).max_score == rubric.max_score
    assert [path.name for path in theirs.parent.iterdir()] == [f'{exercise}.yaml']


def test_a_solution_or_a_run_that_is_missing_is_reported(rubric, tmp_path):
    theirs = unpacked(rubric, tmp_path / 'theirs')
    (theirs.parent / 'references' / '1' / 'fleet.csv').unlink()
    (tmp_path / 'solution.py').unlink()

    with pytest.raises(SetcmasError, match=r"line 3: .* 'solution.py', is missing"):
        check(lambda *_: (0, 0), rubric)
    with pytest.raises(SetcmasError, match=r"no file 'references/1/fleet.csv'"):
        read_rubric(theirs)


@pytest.mark.parametrize(
    ('old', 'new', 'message'),
    [
        ('nb_robots: 5', 'hidden: true', 'students can check nothing'),
        ('nb_robots: 5', 'graph: ../g.yaml\n    nb_robots: 5', "names '.*g.yaml', which is"),
        ('path_error', 'answer_error', 'answer_error and direction_error need the solution'),
    ],
)
def test_what_would_be_of_no_use_or_show_the_solution_is_not_handed_out(rubric, old, new, message):
    rubric.write_text(RUBRIC.replace(old, new))
    (rubric.parent.parent / 'g.yaml').write_text('edges: [1 - 2]\n')

    with pytest.raises(SetcmasError, match=message):
        handout(read_rubric(rubric))
