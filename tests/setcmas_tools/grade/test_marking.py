"""Marks from runs: what needs something else, what is hidden, what scripts say of themselves."""

import msgspec
import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_tools.grade.check import runs_here
from setcmas_tools.grade.marking import mark
from setcmas_tools.grade.marks import Marks, ScenarioRun
from setcmas_tools.grade.rubric import read_rubric
from setcmas_tools.submissions.student import Student

RUBRIC = """\
solution: leader_follower_formation
scenarios:
  - name: shown
    nb_robots: 3
    duration: 4
    criteria:
      - {name: places, metric: position_error, below: 0.1, points: 2, hint: Take your place.}
      - {name: apart, metric: least_separation, above: 0.1, needs: places}
  - name: kept
    hidden: true
    nb_robots: 3
    duration: 1
    criteria: [{metric: least_separation, above: 0.1, hidden: true}]
"""
FORGING = """\
task = 'formation'
PLACES = [[-5, 0], [0, 0]]  # where they are

def control(robotNo, nbRobots, poses, t):
    return 0, 0
"""


@pytest.fixture
def rubric(tmp_path):
    (tmp_path / 'r.yaml').write_text(RUBRIC)
    return read_rubric(tmp_path / 'r.yaml')


def test_a_script_cannot_say_what_it_is_measured_by(rubric, tmp_path):
    script = tmp_path / 'forging.py'
    script.write_text(FORGING)
    marks = mark(rubric, runs_here(str(script)), 'forging', Student('Eve'))
    shown, kept = marks.scenarios
    assert [one.points for one in shown.criteria] == [0, 0]
    assert shown.criteria[1].reached > 0.1  # apart, but not where they have to be
    assert shown.criteria[1].hint == "This counts only with points for 'places'."
    assert (kept.points, kept.hidden, kept.paths) == (1, True, ())
    assert [len(path.wanted) for path in shown.paths] == [41, 41, 41]
    assert msgspec.json.decode(msgspec.json.encode(marks), type=Marks) == marks


def test_a_run_that_did_not_reach_its_end_has_no_points(rubric):
    run = runs_here('leader_follower_formation')

    def broken(scenario):
        return ScenarioRun(run(scenario).run, is_complete=False)

    assert mark(rubric, broken, '', Student('')).score == 0
    assert mark(rubric, run, '', Student('')).score > 0


def test_what_was_not_reached_says_why(rubric, tmp_path):
    text = """\
solution: consensus
scenarios:
  - {name: all, nb_robots: 3, duration: 9, criteria: [{metric: settling_time, at_most: 9}]}
"""
    (tmp_path / 'r.yaml').write_text(text)
    rubric = read_rubric(tmp_path / 'r.yaml')

    def reached(line, run=None):
        script = tmp_path / 'law.py'
        script.write_text(f'def control(i, n, poses, t):\n    {line}\n')
        marks = mark(rubric, run or runs_here(str(script)), '', Student(''))
        return marks.scenarios[0].criteria[0].reached_text

    assert reached('return 0, 0') == 'none: no robot moved'
    assert reached('return i, 0') == 'none: it never got there'
    assert reached('return 1 / 0, 0') == 'none: the script failed'
    assert reached('', lambda _: ScenarioRun(None)) == 'none: it did not run'


def test_a_solution_that_fails_is_the_teachers_to_mend(tmp_path):
    (tmp_path / 'r.yaml').write_text(RUBRIC.replace('leader_follower_formation', 'bad.py', 1))
    (tmp_path / 'bad.py').write_text(FORGING.replace('return 0, 0', 'return 1 / 0'))
    rubric = read_rubric(tmp_path / 'r.yaml')
    with pytest.raises(SetcmasError, match=r"scenario 'shown' of .*bad\.py, line 5"):
        mark(rubric, runs_here('consensus'), '', Student(''))
