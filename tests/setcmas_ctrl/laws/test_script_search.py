from pathlib import Path

import numpy as np
import pytest
import yaml

from setcmas_ctrl.control_law import ControlLaw
from setcmas_ctrl.laws.control_options import LawOptions
from setcmas_ctrl.laws.script_loader import ALGORITHMS, EXERCISES
from setcmas_ctrl.laws.script_search import LawScripts, exercise_of, is_unfilled, unfilled_note
from setcmas_simu.errors import SetcmasError

LEADER = 'V = 0.3\ndef control(robotNo, nbRobots, poses, t):\n    return V, 0.0\n'
FOLLOWER = 'K = 0.1\nW = 2 * K\ndef control(robotNo, nbRobots, poses, t):\n    return 0.0, W\n'


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, text in (('leader', LEADER), ('follower', FOLLOWER), ('1:a,b', LEADER)):
        (tmp_path / f'{name}.py').write_text(text)


def velocities(scripts, nb_robots, poses=None):
    scripts.check(nb_robots)
    paths = [(robot, scripts.script(robot)) for robot in range(1, nb_robots + 1)]
    laws = [ControlLaw(path, robot, nb_robots, scripts.settings[path]) for robot, path in paths]
    return [law(np.zeros((3, nb_robots)), 0.0) for law in laws]


def test_each_robot_has_its_script(folder):
    scripts = LawScripts('1:leader.py,2-3:follower')

    assert velocities(scripts, 3) == [(0.3, 0.0), (0.0, 0.2), (0.0, 0.2)]
    assert [scripts.script(robot).name for robot in (1, 3)] == ['leader.py', 'follower.py']


def test_values_go_to_the_scripts_that_have_the_name(folder):
    scripts = LawScripts('1:leader.py,2:follower.py', settings={'K': 0.2, 'V': 0.4})

    assert velocities(scripts, 2) == [(0.4, 0.0), (0.0, 0.4)]


def test_a_file_whose_name_begins_as_robots_do_is_meant_by_its_folder(folder):
    assert velocities(LawScripts('./1:a,b.py'), 2) == [(0.3, 0.0)] * 2
    assert velocities(LawScripts('1:./1:a,b.py,2:follower.py'), 2) == [(0.3, 0.0), (0.0, 0.2)]


@pytest.mark.parametrize(
    ('algo', 'settings', 'message'),
    [
        ('1:leader.py', {}, r"--algo '1:leader\.py' has no control law for robots 2-3; add it"),
        ('1-3:leader.py,4:follower.py', {}, '--algo names robot 4; the fleet has robots 1 to 3'),
        ('1:leader.py,2-3:none.py', {}, r"script 'none\.py' of --algo not found"),
        ('1:leader.py,1-3:follower.py', {}, 'names robot 1 twice'),
        (
            '1:leader.py,2-3:follower.py',
            {'k': 1.0},
            r'setting k: no control script assigns it: leader\.py has V; follower\.py has K, W',
        ),
        ('leader.py', {'K': 1.0}, r"setting K: leader\.py has no module-level name 'K'"),
    ],
)
def test_mistakes_are_reported(folder, algo, settings, message):
    with pytest.raises(SetcmasError, match=message):
        LawScripts(algo, settings=settings).check(3)


def test_a_file_that_hides_a_built_in_law_is_reported(folder, tmp_path):
    assert LawScripts('consensus').notes == []
    (tmp_path / 'consensus.py').write_text(LEADER)

    assert LawScripts('leader').notes == []
    assert LawScripts('./consensus.py').notes == []
    (note,) = LawScripts('1:leader,2:consensus').notes
    assert note.startswith('--algo consensus runs consensus.py in this folder instead of the')


@pytest.fixture
def copy(tmp_path):
    """A function that writes a copy of the consensus exercise with a part of it replaced."""

    def copy(old='', new=''):
        text = EXERCISES.file('consensus').read_text()
        assert old in text
        path = tmp_path / 'mine.py'
        path.write_text(text.replace(old, new))
        return path

    return copy


@pytest.mark.parametrize(
    ('old', 'new', 'unfilled'),
    [
        ('', '', True),
        ('# TODO: add', '# What is to be added?', True),
        ('K = 0.5', 'K = 0.7', True),
        ('pass', 'v += 1', False),
        ('pass', 'v +=', False),  # reported where it is loaded
    ],
)
def test_a_copy_is_not_filled_in_until_its_maths_changes(copy, old, new, unfilled):
    script = copy(old, new)
    assert is_unfilled(script) == unfilled
    assert ('mine.py is not filled in yet' in unfilled_note(script)) == unfilled


def test_a_script_declares_its_exercise_or_has_its_name(copy, tmp_path):
    assert exercise_of(copy()) == 'consensus'
    assert exercise_of(copy("exercise = 'consensus'", '')) == ''
    assert exercise_of(ALGORITHMS.file('nav_wp')) == 'nav_wp'
    assert not is_unfilled(ALGORITHMS.file('nav_wp'))
    assert unfilled_note(EXERCISES.file('nav_wp')).startswith('exercise nav_wp is not filled in')


def test_a_built_in_law_is_passed_to_a_node_by_its_path(folder):
    """So that the node need not look for it among all packages."""

    def passed(algo, **others):
        _, values = LawOptions(algo=algo, **others).arguments()
        return yaml.safe_load(values)['algo']

    assert Path(passed('nav-wp')) == ALGORITHMS.file('nav_wp')
    assert Path(passed('consensus', exercise=True)) == EXERCISES.file('consensus')
    for algo in ('leader', './1:a,b', 'external', '1:leader,2-4:consensus'):
        assert passed(algo) == algo
