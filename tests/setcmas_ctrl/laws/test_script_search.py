import numpy as np
import pytest

from setcmas_ctrl.control_law import ControlLaw
from setcmas_ctrl.laws.script_search import LawScripts
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


def test_one_script_is_for_every_robot_of_any_fleet(folder):
    scripts = LawScripts('leader')

    assert velocities(scripts, 5) == [(0.3, 0.0)] * 5
    assert [path.name for path in scripts.paths] == ['leader.py']


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
        ('1:leader.py,2-3:none.py', {}, r"control script 'none\.py' not found"),
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
