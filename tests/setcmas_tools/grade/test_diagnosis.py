"""Hints by experiment: the mistake that a submission made, and nothing that it did not do."""

import re

import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_tools.grade.check import runs_here
from setcmas_tools.grade.marking import mark
from setcmas_tools.grade.rubric import read_rubric
from setcmas_tools.submissions.submissions import Submission
from setcmas_tools.submissions.submitted_files import Student

LAW = """\
import numpy as np

K = 0.5


def control(robotNo, nbRobots, poses, t):
    p = poses[:2]
    v = np.zeros(2)
    for j in range(nbRobots):
        if np.isfinite(p[0, j]):
            v -= K / nbRobots * (p[:, robotNo - 1] - p[:, j])
    return v[0], v[1]
"""
RUBRIC = """\
solution: right.py
scenarios:
  - name: all
    nb_robots: 5
    duration: 25
    criteria:
      - {name: near, metric: path_error, at_most: 0.01, hint: Read the formula.}
      - {name: met, metric: disagreement, at_most: 0.05, hint: Meet.}
  - name: ring
    nb_robots: 4
    duration: 25
    graph: ring
    loss: 0.3
    delay: 0.1
    criteria: [{metric: path_error, at_most: 0.01, hint: Look around.}]
  - name: secret
    hidden: true
    nb_robots: 2
    duration: 2
    criteria: [{metric: path_error, at_most: 0.01, hint: SECRET}]
"""
CTC = """\
def ctc(pos, last_pos, t):
    gone = sum((pos - last_pos) ** 2) ** 0.5
    return gone > 0.25
"""
SI_TO_UNI = """\
from math import cos, sin


def si_to_uni(velocity, pose, komega):
    (vx, vy), theta = velocity, pose[2]
    V = vx * cos(theta) + vy * sin(theta)
    omega = (vy * cos(theta) - vx * sin(theta)) / 0.2
    return V, omega
"""
BARE_RUBRIC = """\
solution: right.py
function: {}
scenarios:
  - name: five
    algo: consensus
    nb_robots: 5
    duration: 25
    vnom: 0.47
    random_poses: auto
    seed: 2
    criteria: [{{metric: answer_error, at_most: 0.02, hint: Read the formula.}}]
"""


@pytest.fixture
def hints(tmp_path):
    """A function that returns the hints for a right solution with some of its text replaced."""

    def hints(*replaced, rubric=RUBRIC, right=LAW):
        (tmp_path / 'right.py').write_text(right)
        (tmp_path / 'r.yaml').write_text(rubric)
        text = right
        for old, new in replaced:
            assert old in text
            text = text.replace(old, new)
        script = tmp_path / 'law.py'
        script.write_text(text)
        read = read_rubric(tmp_path / 'r.yaml')
        marks = mark(read, runs_here(str(script), read.function), Submission('', Student('')))
        return [one.hint for each in marks.scenarios for one in each.criteria if one.hint]

    return hints


@pytest.mark.parametrize(
    ('old', 'new', 'said'),
    [
        ('v -=', 'v +=', 'opposite'),
        ('v[0], v[1]', 'v[1], v[0]', 'swapped'),
        ('v[0], v[1]', '-v[1], v[0]', 'turned by +90'),
        ('v[0], v[1]', 'np.hypot(*v), np.arctan2(v[1], v[0])', 'speed and turn rate'),
        (' / nbRobots', '', 'N times too large, where N is'),
        ('/ nbRobots', '/ (nbRobots - 1)', 'N/(N-1) times too large, where N is'),
        ('K = 0.5', 'K = 1.3', 'as if K were 1.3, not 0.5'),
        ('v -= K', 'v -= 40 * K', 'always saturated at the speed limit'),
        ('v[0], v[1]', '(0, 0) if robotNo == 1 else v', 'The velocities of robot 1 are all zero.'),
        (
            'v[0], v[1]',
            'tuple(v[:: 1 if robotNo == 1 else -1])',
            'The velocities of all robots but robot 1 are the right ones with vx and',
        ),
    ],
)
def test_a_mistake_is_explained_by_the_run_that_it_reproduces(hints, old, new, said):
    [hint] = hints((old, new))
    assert said in hint
    assert 'formula' not in hint


def test_an_angle_in_degrees_gives_a_factor_of_180_over_pi(hints):
    slow = LAW.replace('K = 0.5', 'K = 0.005')
    [hint] = hints(('K / nbRobots', 'np.degrees(K) / nbRobots'), right=slow)
    assert hint == 'Your velocities have the right directions, but are 180/pi times too large.'


@pytest.mark.parametrize(
    ('new', 'said'),
    [
        ('True', 'always holds'),
        ('False', 'never holds'),
        ('gone > 25', 'never holds'),
        ('gone > 0', 'as soon as the robot has moved at all'),
        ('t % 1 < 0.1', 'for all robots at the same times'),
        ('gone > 1', 'is 1 m away from the last position sent; it must hold only beyond 0.25 m'),
        ('gone > 0.15', 'is 0.15 m away from the last position sent; that is too early'),
    ],
)
def test_mistakes_of_a_condition_are_recognised_without_a_list(hints, new, said):
    [hint] = hints(('gone > 0.25', new), rubric=BARE_RUBRIC.format('ctc'), right=CTC)
    assert said in hint


def test_a_condition_that_is_the_opposite_of_the_right_one_is_recognised(hints):
    right = CTC.replace('gone > 0.25', 't > 10')
    [hint] = hints(('t > 10', 't <= 10'), rubric=BARE_RUBRIC.format('ctc'), right=right)
    assert hint == 'Your condition is the opposite of the right one: check the comparison.'


@pytest.mark.parametrize(
    ('new', 'said'),
    [
        ('0, 0', 'V and the turn rate are always zero'),
        ('V, 0', 'never turn'),
        ('-V, omega', 'V has the wrong sign; the turn rate is right'),
        ('omega, V', 'You return the turn rate first'),
        ('V, -3 * omega', 'your turn rate is 3 times too large and has the wrong sign.'),
    ],
)
def test_mistakes_of_a_si_to_uni_are_recognised_without_a_list(hints, new, said):
    rubric = BARE_RUBRIC.format('si_to_uni')
    [hint] = hints(('return V, omega', f'return {new}'), rubric=rubric, right=SI_TO_UNI)
    assert said in hint


def test_what_nothing_explains_is_measured_and_the_lecturers_own_hint_follows(hints):
    when = 'if robotNo == 2 and t > 3: v = v + 0.2\n    return v[0], v[1]'
    [hint] = hints(('return v[0], v[1]', when))
    assert hint.startswith("In 'all', robot 2 first differs from the solution for more than two")
    assert 'calls at t = 3.2 s: its velocity' in hint
    assert hint.endswith('This affects only robot 2. Read the formula.')
    [hint] = hints(('return v[0], v[1]', 'return np.random.normal(0, 1, 2)'))
    assert re.search(r'robot 1 first differs from the solution for .* at t = 0\.\d s', hint)


def test_a_lecturers_mistake_is_recognised_unless_another_does_the_same(hints):
    listed = "mistakes:\n  - change: {'range(nbRobots)': 'range(2)'}\n    hint: Only two.\n"
    other = "  - change: {'range(nbRobots)': '(0, 1)'}\n    hint: Something else.\n"
    two = ('range(nbRobots)', 'range(2)')
    assert hints(two, rubric=RUBRIC + listed) == ['Only two.']
    assert 'first differs' in hints(two, rubric=RUBRIC + listed + other)[0]
    assert 'opposite' in hints(('v -=', 'v +='), rubric=RUBRIC + listed)[0]


def test_a_term_with_a_wrong_factor_is_named(hints):
    term = "mistakes:\n  - {change: {' - p[:, j]': ''}, hint: Add p_j., term: p_j}\n"
    [hint] = hints((' - p[:, j]', ' - 0.4 * p[:, j]'), rubric=RUBRIC + term)
    assert hint == 'In your law, p_j is 2.5 times too small; the rest is right.'
    [hint] = hints((' - p[:, j]', ' - K * p[:, j]'), rubric=RUBRIC + term)
    assert hint.endswith('p_j is 2 times too small: does K multiply it, too?')
    [hint] = hints((' - p[:, j]', ' + p[:, j]'), rubric=RUBRIC + term)
    assert hint == 'In your law, p_j has the wrong sign; the rest is right.'


def test_only_what_students_see_gives_hints(hints):
    assert hints(('K / nbRobots', '(K if nbRobots > 2 else 2) / nbRobots')) == []
    shown = '- {name: near, metric: path_error, at_most: 0.01, hint: Read the formula.}'
    hidden = shown.replace('hint:', 'hidden: true, hint:')
    [hint] = hints(('v -=', 'v +='), rubric=RUBRIC.replace(shown, hidden))
    assert 'opposite' in hint


@pytest.mark.parametrize(
    ('listed', 'said'),
    [
        ('{change: {gain: 2}, hint: A}', "line 22: the solution, right.py, has no 'gain'"),
        ('{script: "def control(", hint: A}', 'line 22: this mistake is not valid Python'),
        ('{change: {}, hint: A}', 'line 22: .*must be parts of the solution'),
    ],
)
def test_an_impossible_mistake_is_reported_with_its_line(hints, listed, said):
    with pytest.raises(SetcmasError, match=said):
        hints(rubric=f'{RUBRIC}mistakes:\n  - {listed}\n')
