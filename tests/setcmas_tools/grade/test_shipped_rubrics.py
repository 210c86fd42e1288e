"""The rubrics that ship: the solution gets all, typical mistakes the part that they should."""

import re

import pytest

from setcmas_ctrl.scripts.loader import EXERCISES
from setcmas_tools.grade.check import runs_here
from setcmas_tools.grade.marking import mark
from setcmas_tools.grade.rubric import rubric_of_exercise
from setcmas_tools.submissions.student import Student

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

MISTAKES = {
    # the sign: nothing but a leader that goes its way
    ('consensus', 'v -=', 'v +='): (0, 0),
    ('nav_wp', 'KP * (w - p)', 'KP * (p - w)'): (0, 0),
    ('traj_tracking', 'KP * (r - p)', 'KP * (p - r)'): (0, 0),
    ('traj_tracking', '+ r_dot', '- r_dot'): (1, 2),
    ('leader_follower_formation', '-KF * (', 'KF * ('): (4, 4),
    ('ctc', ') > THRESHOLD', ') < THRESHOLD'): (2, 2),
    # the wrong column: the last robot has none, or all robots are the first one
    ('consensus', 'p - positions', 'positions[:, robotNo] - positions'): (0, 0),
    ('nav_wp', 'poses[:2, robotNo - 1]', 'poses[:2, 0]'): (6, 6),
    ('leader_follower_formation', 'PLACES[robotNo - 2]', 'PLACES[robotNo - 3]'): (2, 2),
    # no saturation of the idea: full speed whatever is left to go
    ('consensus', 'return v[0], v[1]', 'v *= 100\n    return v[0], v[1]'): (0, 4),
    ('nav_wp', 'return v[0], v[1]', 'v *= 100\n    return v[0], v[1]'): (8, 8),
    # off by one, and a list that begins with its second point
    ('consensus', 'range(nbRobots)', 'range(1, nbRobots)'): (3, 3),
    ('consensus', 'range(nbRobots)', 'range(nbRobots - 1)'): (3, 3),
    ('nav_wp', 'current = 0', 'current = 1'): (8, 8),
    ('nav_wp', '% len(WPL)', '% 3'): (4, 4),
    ('nav_wp', 'current + 1)', 'current + 2)'): (4, 4),
    # the own pose left out
    ('consensus', '(p - positions[:, j])', '-positions[:, j]'): (0, 0),
    ('nav_wp', 'KP * (w - p)', 'KP * w'): (0, 0),
    # a part left out: feedforward, the next waypoint, one of two components
    ('traj_tracking', ' + r_dot', ''): (3, 3),
    ('leader_follower_formation', ' + v_leader', ''): (6, 6),
    ('nav_wp', 'if np.linalg.norm(w - p) <', 'if 10 <'): (4, 4),
    # another factor, or another norm
    ('nav_wp', 'KP * (w - p)', '(w - p)'): (8, 8),
    ('traj_tracking', 'KP * (r - p)', '(r - p)'): (8, 8),
    ('traj_tracking', 'KP * (r - p) +', 'KP * (r - p) + KP *'): (8, 8),
    ('consensus', 'K / nbRobots', 'K'): (0, 3),
    ('consensus', 'K / nbRobots', 'K / (nbRobots - 1)'): (5, 5),
    ('consensus', 'K / nbRobots', 'K / 8'): (7, 7),
    ('ctc', 'np.linalg.norm(gap)', 'np.abs(gap).sum()'): (4, 4),
    ('ctc', 'np.linalg.norm(gap)', 'np.abs(gap).max()'): (4, 4),
    ('ctc', 'np.linalg.norm(gap)', 'gap @ gap'): (4, 4),
    ('ctc', 'return bool(', 'gap[1] = 0\n    return bool('): (2, 4),
    ('ctc', 'return bool(', 'return False and bool('): (0, 0),
    # a law, or a condition, that fails: the engine sends in its place
    ('ctc', 'return bool(', 'return unknown('): (0, 0),
    ('ctc', 'return bool(', 'return float("nan") * bool('): (0, 0),
    ('consensus', 'v -= K', 'v -= k'): (0, 0),
}
"""Exercise, what is right in its solution, what stands there instead: least and most points."""


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


@pytest.mark.parametrize(
    ('name', 'old', 'new'), MISTAKES, ids=lambda text: re.sub(r'\s+', '', text)
)
def test_a_typical_mistake_gets_the_points_for_what_is_right(marks, name, old, new):
    least, most = MISTAKES[name, old, new]
    found = marks(name, [*solution(name), (old, new)])
    assert least <= found.score <= most
    failed = any(scenario.failure for scenario in found.scenarios)
    hints = [one.hint for scenario in found.scenarios for one in scenario.criteria if one.hint]
    assert len([one for one in hints if 'counts only with' not in one]) == (not failed)
    assert not found.is_full
