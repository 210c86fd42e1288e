import re

import numpy as np
import pytest

from setcmas_ctrl.control.control_law import ControlLaw
from setcmas_ctrl.scripts.loader import ALGORITHMS, EXERCISES, find_script, load_script
from setcmas_simu.errors import SetcmasError
from setcmas_tools import simulate

FILES = sorted({EXERCISES.file(name) for name in EXERCISES.plugins()})
LAWS = [path for path in FILES if path.stem != 'ctc']
PARTS = ('Goal', 'Formula', 'What to observe', 'Commands')


def test_each_law_but_the_second_formation_has_an_exercise():
    laws = {*ALGORITHMS.plugins(), 'ctc'} - {'leader_follower_distance_formation', 'wp_nav'}

    assert {path.stem for path in FILES} == laws


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
    given = {name: value for name, value in vars(law).items() if name.isupper() and value}
    names = given.keys() & vars(exercise).keys()

    assert names
    assert {name: getattr(exercise, name) for name in names} == {
        name: given[name] for name in names
    }


def test_only_with_exercise_a_name_means_one(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    assert find_script('consensus') == ALGORITHMS.file('consensus')
    assert find_script('consensus', exercise=True) == EXERCISES.file('consensus')
    assert find_script('wp_nav', exercise=True) == EXERCISES.file('nav_wp')
    (tmp_path / 'consensus.py').touch()
    assert find_script('consensus', exercise=True) == tmp_path / 'consensus.py'
    with pytest.raises(SetcmasError, match=r'exercises: bearing_formation.*did you mean ctc'):
        find_script('ctcc', exercise=True)


def test_the_triggering_condition_sends_always_as_it_is():
    path = find_script('ctc', exercise=True)
    module = load_script(path, 1, expected='ctc(pos, last_pos, t)')

    assert module.ctc(np.zeros(3), np.zeros(3), 0.0) is True
    with pytest.raises(SetcmasError, match='no function control'):
        ControlLaw(path, 1, 1)
