import re

import numpy as np
import pytest

from setcmas_ctrl.control_law import ControlLaw
from setcmas_ctrl.laws.script_loader import ALGORITHMS, EXERCISES, load_script
from setcmas_ctrl.laws.script_search import find_script
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.planar_pose import through_quaternion
from setcmas_tools import simulate

FILES = sorted({EXERCISES.file(name) for name in EXERCISES.plugins()})
OF_OTHER_FUNCTIONS = {'ctc', 'point_ahead'}
LAWS = [path for path in FILES if path.stem not in OF_OTHER_FUNCTIONS]
PARTS = ('Goal', 'Formula', 'What to observe', 'Commands')


def test_each_law_but_the_second_formation_has_an_exercise():
    laws = {*ALGORITHMS.plugins()} - {'leader_follower_distance_formation', 'wp_nav'}

    assert {path.stem for path in FILES} == laws | OF_OTHER_FUNCTIONS


@pytest.mark.parametrize('path', FILES, ids=lambda path: path.stem)
def test_each_states_goal_formula_observations_and_commands_and_leaves_the_maths(path):
    text = path.read_text()
    statement = text.split('"""')[1]

    assert statement.startswith('Exercise: ')
    for part in PARTS:
        assert re.search(rf'^{part}', statement, re.MULTILINE), part
    assert '# TODO' in text.replace(statement, '')
    assert 'setcmas check my_' in statement


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


SOLUTION = EXERCISES.file('point_ahead').with_name('point_ahead_solution.py')


def east(robotNo, nbRobots, poses, t):
    return 0.5, 0.0


def test_robots_stand_with_the_point_ahead_as_it_is():
    run = simulate(east, 2, 3, si_to_uni=find_script('point_ahead', exercise=True))

    assert (run.poses[-1] == through_quaternion(run.poses[0])).all()


@pytest.mark.parametrize(
    ('L', 'is_monotonic', 'settles'),
    [(0.15, True, True), (0.08, False, True), (0.04, False, False)],
)
def test_the_heading_oscillates_below_0_1_m_and_does_not_settle_below_0_05_m(
    tmp_path, L, is_monotonic, settles
):
    # e(k + 1) = e(k) - (0.2 s) (0.5 m/s) / L sin(e(k)): its factor is 1 - 0.1 m / L near e = 0.
    script = tmp_path / 'ahead.py'
    script.write_text(SOLUTION.read_text().replace('L = 0.15', f'L = {L}'))
    run = simulate(east, 1, 20, si_to_uni=script, poses=[[0.0], [0.0], [0.3]])
    heading = run.poses[::2, 2, 0]

    assert (np.diff(heading) <= 0).all() == is_monotonic
    assert (abs(heading[-1]) < 1e-3) == settles
