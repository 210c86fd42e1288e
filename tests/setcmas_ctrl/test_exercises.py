import re

import numpy as np
import pytest

from setcmas_ctrl.control.control_law import ControlLaw
from setcmas_ctrl.scripts.loader import ALGORITHMS, EXERCISES, find_script, load_script
from setcmas_simu.errors import SetcmasError
from setcmas_tools import simulate

FILES = sorted({EXERCISES.file(name) for name in EXERCISES.offers()})
LAWS = [path for path in FILES if path.stem != 'ctc']
PARTS = ('Goal', 'Formula', 'What to observe', 'Commands')


def test_the_exercises():
    assert [path.stem for path in FILES] == [
        'consensus',
        'ctc',
        'leader_follower_formation',
        'nav_wp',
        'traj_tracking',
    ]


@pytest.mark.parametrize('path', FILES, ids=lambda path: path.stem)
def test_each_states_goal_formula_observations_and_commands_and_leaves_the_maths(path):
    text = path.read_text()
    statement = text.split('"""')[1]

    assert statement.startswith('Exercise: ')
    for part in PARTS:
        assert re.search(rf'^{part}', statement, re.MULTILINE), part
    assert '# TODO' in text.replace(statement, '')
    assert 'setcmas new my_' in statement
    assert f'--from {path.stem} --exercise' in statement


@pytest.mark.parametrize('path', LAWS, ids=lambda path: path.stem)
def test_as_it_is_the_robots_stand_still_without_an_error(path):
    said = []

    run = simulate(path, nb_robots=6, duration=5, warn=said.append)

    assert said == []
    assert (run.velocities == 0).all()


@pytest.mark.parametrize('path', LAWS, ids=lambda path: path.stem)
def test_numbers_are_those_of_the_built_in_law(path):
    exercise, law = load_script(path, 1), load_script(ALGORITHMS.file(path.stem), 1)
    names = {name for name in vars(exercise) if name.isupper()}

    assert names
    for name in names:
        assert getattr(exercise, name) == getattr(law, name), name


SOLUTIONS = {
    'consensus': [('        pass\n', '        v += -K / nbRobots * (p - positions[:, j])\n')],
    'nav_wp': [
        ('    # TODO 1: compute v\n', '    v = KP * (w - p)\n'),
        (
            '    return v[0]',
            '    if np.linalg.norm(w - p) < REACHED:\n'
            '        current = (current + 1) % len(WPL)\n    return v[0]',
        ),
    ],
    'traj_tracking': [
        ('np.array([R, 0.0])', 'R * np.array([np.cos(W * t), np.sin(W * t)])'),
        ('np.zeros(2)  # TODO 2', 'R * W * np.array([-np.sin(W * t), np.cos(W * t)])  # TODO 2'),
        ('np.zeros(2)  # TODO 3', 'KP * (r - p) + r_dot  # TODO 3'),
    ],
    'leader_follower_formation': [
        ('        return 0, 0\n    if', '        return tuple(v_leader)\n    if'),
        ('np.zeros(2)  # TODO 2', '-KF * (p - leader - place) + v_leader  # TODO 2'),
    ],
}


@pytest.mark.parametrize('name', SOLUTIONS)
def test_with_the_maths_filled_in_it_does_what_the_built_in_law_does(tmp_path, name):
    text = EXERCISES.file(name).read_text()
    for blank, solution in SOLUTIONS[name]:
        assert text.count(blank) == 1
        text = text.replace(blank, solution)
    path = tmp_path / 'mine.py'
    path.write_text(text)

    mine, built_in = (simulate(law, nb_robots=5, duration=30) for law in (path, name))

    np.testing.assert_allclose(mine.poses[-1, :2], built_in.poses[-1, :2], atol=0.05)


def test_only_with_exercise_a_name_means_one(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    assert find_script('consensus') == ALGORITHMS.file('consensus')
    assert find_script('consensus', exercise=True) == EXERCISES.file('consensus')
    assert find_script('wp_nav', exercise=True) == EXERCISES.file('nav_wp')
    (tmp_path / 'consensus.py').touch()
    assert find_script('consensus', exercise=True) == tmp_path / 'consensus.py'
    with pytest.raises(SetcmasError, match=r'did you mean ctc\? exercises: consensus, ctc'):
        find_script('ctcc', exercise=True)


def test_the_triggering_condition_sends_always_as_it_is():
    path = find_script('ctc', exercise=True)
    module = load_script(path, 1, expected='ctc(pos, last_pos, t)')

    assert module.ctc(np.zeros(3), np.zeros(3), 0.0) is True
    with pytest.raises(SetcmasError, match='no function control'):
        ControlLaw(path, 1, 1)
