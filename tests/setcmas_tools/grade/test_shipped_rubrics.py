"""The rubrics that ship: the solution gets all points, a class what a lecturer would give."""

import zipfile
from pathlib import Path

import pytest
import yaml

from setcmas_ctrl.scripts.loader import EXERCISES
from setcmas_tools.grade import class_grading
from setcmas_tools.grade.check import runs_here
from setcmas_tools.grade.grade_options import GradeOptions
from setcmas_tools.grade.marking import mark
from setcmas_tools.grade.rubric import rubric_of_exercise
from setcmas_tools.offline.kernel_confinement import obstacle
from setcmas_tools.submissions.student import Student
from setcmas_tools.submissions.submissions import find_submissions

DATA = Path(__file__).parents[2] / 'data' / 'class_of_thirty.yaml'
WRONG_FACTORS = {'Hal Hill', 'Ida Ito', 'Max Mora', 'Nia Nash', 'Dov Daly'}
"""Students whose law has the right form; the rubric was too strict with them once."""

EXERCISE_NAMES = ['consensus', 'ctc', 'leader_follower_formation', 'nav_wp', 'traj_tracking']

FILLED_IN = {
    'consensus': {'pass': 'v -= K / nbRobots * (p - positions[:, j])'},
    'ctc': {
        'return True': 'gap = np.array(pos[:2]) - last_pos[:2]\n'
        '    return bool(np.linalg.norm(gap) > THRESHOLD)'
    },
    'leader_follower_formation': {
        'return 0, 0\n    if robotNo - 2': 'return v_leader\n    if robotNo - 2',
        'v = np.zeros(2)': 'v = -KF * ((p - leader) - place) + v_leader',
    },
    'nav_wp': {
        'v = np.zeros(2)': 'v = KP * (w - p)\n    if np.linalg.norm(w - p) < REACHED:\n'
        '        current = (current + 1) % len(WPL)'
    },
    'traj_tracking': {
        'np.array([R, 0.0])': 'R * np.array([np.cos(W * t), np.sin(W * t)])',
        'r_dot = np.zeros(2)': 'r_dot = R * W * np.array([-np.sin(W * t), np.cos(W * t)])',
        'v = np.zeros(2)': 'v = KP * (r - p) + r_dot',
    },
}
"""What takes the place of parts of each exercise."""


@pytest.fixture(scope='session')
def rubrics():
    return {name: rubric_of_exercise(name) for name in EXERCISE_NAMES}


@pytest.fixture
def marks(rubrics, tmp_path):
    """A function that marks an exercise with some of its text replaced."""

    def marks(name, replaced):
        text = EXERCISES.file(name).read_text()
        for old, new in replaced:
            assert old in text
            text = text.replace(old, new, 1)
        script = tmp_path / f'my_{name}.py'
        script.write_text(text)
        rubric = rubrics[name]
        run = runs_here(str(script), rubric.function)
        return mark(rubric, run, script.name, Student('Ada'), script)

    return marks


def solution(name):
    return list(FILLED_IN[name].items())


@pytest.mark.parametrize('name', EXERCISE_NAMES)
def test_a_solution_gets_all_points_and_an_untouched_exercise_none(marks, name):
    right, untouched = marks(name, solution(name)), marks(name, [('# TODO', '# I do not know')])
    assert right.is_full
    assert right.score == right.max_score == 10
    assert not any(one.hint for scenario in right.scenarios for one in scenario.criteria)
    assert untouched.unfilled
    assert (untouched.score, untouched.max_score) == (0, 10)


def handed_in(entries, folder):
    """Write the submissions as Moodle does, a folder for each student."""
    for entry in entries:
        place = folder / entry['student']
        place.mkdir(parents=True)
        if 'zip' in entry:
            with zipfile.ZipFile(place / entry['zip'], 'w') as archive:
                for name, content in entry['files'].items():
                    archive.writestr(name, content)
        else:
            for name, content in entry['files'].items():
                (place / name).write_text(content)
    return folder


@pytest.mark.skipif(bool(obstacle()), reason=obstacle())
@pytest.mark.parametrize(
    'wanted',
    [
        pytest.param(WRONG_FACTORS, id='wrong factors'),
        pytest.param(None, id='all', marks=pytest.mark.nightly),
    ],
)
def test_a_class_gets_the_points_that_a_lecturer_would_give(tmp_path, wanted):
    entries = {entry['student'].split('_')[0]: entry for entry in yaml.safe_load(DATA.read_text())}
    assert len(entries) == 30
    chosen = {name: entry for name, entry in entries.items() if not wanted or name in wanted}
    place = handed_in(chosen.values(), tmp_path / 'class')
    rubric = rubric_of_exercise('consensus')
    options = GradeOptions(jobs=1, call_timeout=2)

    submissions = find_submissions(place, rubric.function)
    marks = class_grading.grade(submissions, rubric, tmp_path / 'grades', options)

    scores = {one.student.name: one.score for one in marks}
    assert scores.keys() == chosen.keys()
    unfair = {
        name: (scores[name], entry['points'], entry['why'])
        for name, entry in chosen.items()
        if not entry['points'][0] <= scores[name] <= entry['points'][1]
    }
    assert unfair == {}
