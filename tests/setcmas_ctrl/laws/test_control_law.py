import signal

import numpy as np
import pytest

from setcmas_ctrl.laws.control_law import ControlLaw, LawScripts
from setcmas_ctrl.laws.script_errors import ControlError, ErrorReports
from setcmas_simu.errors import SetcmasError

POSES = np.zeros((3, 2))


def law(tmp_path, body):
    path = tmp_path / 'law.py'
    path.write_text(f'import numpy as np\ndef control(i, n, poses, t):\n    {body}\n')
    return ControlLaw(path, 2, 2)


def test_the_script_gets_its_number_the_fleet_and_the_time(tmp_path):
    assert law(tmp_path, 'return i + n, t')(POSES, 1.5) == (4.0, 1.5)


def test_the_script_cannot_change_the_poses_of_others(tmp_path):
    poses = np.zeros((3, 2))

    law(tmp_path, 'poses[:] = 9; return 0, 0')(poses, 0.0)

    assert (poses == 0).all()


@pytest.mark.parametrize(
    ('body', 'message'),
    [
        ('exec("1 / 0")', r'line 3: ZeroDivisionError.*\n    3 \| exec'),
        ('raise type("Odd", (Exception,), {"__str__": lambda s: 1 / 0})', 'line 3: Odd: a Odd'),
        ('return type("Odd", (), {"__repr__": lambda s: 1 / 0})()', 'line 3: .* a Odd: a Odd'),
    ],
)
def test_failures_name_script_and_line_and_quote_it(tmp_path, body, message):
    with pytest.raises(ControlError, match=message):
        law(tmp_path, body)(POSES, 0.0)


def reported(*calls):
    """Return what is said of calls, each of a robot, its law and a time."""
    said = []
    reports = ErrorReports(said.append)
    for robot, called, t in calls:
        try:
            called(POSES, t)
            reports.succeeded(robot, t)
        except ControlError as error:
            reports.failed(robot, t, error)
    return said


def test_results_that_differ_in_their_values_only_are_one_error(tmp_path):
    failing = law(tmp_path, 'return i, t, None')

    said = reported(*((robot, failing, t) for t in (0.0, 0.2, 0.4) for robot in (1, 2)))

    assert [one.partition(': ')[2] for one in said[1:]] == ['the same error as tb3_1']


def test_each_distinct_error_is_reported_once(tmp_path):
    failing = law(tmp_path, 'return (1 / 0, 0) if t < 1 else poses[9] if t < 2 else (0, 0)')
    said = reported(*((2, failing, t) for t in (0.0, 0.2, 0.4, 1.0, 1.2, 2.0, 2.2)))

    assert len(said) == 3
    assert said[0].startswith('tb3_2 at t = 0.0 s: law.py, line 3: ZeroDivisionError')
    assert 'tb3_2 gets zero velocity' in said[0]
    assert 'IndexError' in said[1]
    assert said[2] == 'tb3_2 at t = 2.0 s: works again after 5 calls'


def test_robots_with_the_same_mistake_do_not_fill_the_screen(tmp_path):
    failing = law(tmp_path, 'return 1 / 0, 0')
    said = reported(*((robot, failing, t) for robot in (1, 2, 3) for t in (0.0, 0.2)))

    assert len(said) == 3
    assert 'ZeroDivisionError' in said[0]
    assert said[2] == 'tb3_3 at t = 0.0 s: the same error as tb3_1'


def test_the_users_interrupt_is_not_taken_for_a_fault_of_the_script(tmp_path):
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's & ignores it
    try:
        with pytest.raises(KeyboardInterrupt):
            law(tmp_path, 'raise KeyboardInterrupt')(POSES, 0.0)
    finally:
        signal.signal(signal.SIGINT, before)


HOSTILE = """
import signal
import sys
class Odd(Exception):
    def __str__(self):
        {body}
    __repr__ = __array__ = __float__ = __len__ = __str__
class Number(float):
    def __float__(self):
        {body}
def control(i, n, poses, t):
    {call}
"""


@pytest.mark.parametrize(
    'call', ['raise Odd()', 'return Odd()', 'return Number(1), Number(2)', 'return Odd(), 1']
)
@pytest.mark.parametrize(
    'body', ['sys.exit(3)', 'raise KeyboardInterrupt', 'raise OSError', 'return 7']
)
def test_objects_that_cannot_be_described_stop_their_own_robot_only(tmp_path, call, body):
    path = tmp_path / 'law.py'
    path.write_text(HOSTILE.format(call=call, body=body))

    if call == 'return Number(1), Number(2)' and body == 'return 7':
        return  # it is a number
    with pytest.raises(ControlError, match=r'law\.py'):
        ControlLaw(path, 1, 2)(POSES, 0.0)


@pytest.mark.parametrize(
    ('text', 'shown'),
    [(r'a\ud800b', r'a\ud800b'), (r'a\0b', r'a\x00b'), (r'\x1b[2J', r'\x1b[2J')],
)
def test_what_a_terminal_cannot_show_is_escaped(tmp_path, text, shown):
    with pytest.raises(ControlError) as failure:
        law(tmp_path, f"raise ValueError('{text}')")(POSES, 0.0)

    assert f'ValueError: {shown}' in str(failure.value)
    str(failure.value).encode()


LEADER = 'V = 0.3\ndef control(robotNo, nbRobots, poses, t):\n    return V, 0.0\n'
FOLLOWER = 'K = 0.1\nW = 2 * K\ndef control(robotNo, nbRobots, poses, t):\n    return 0.0, W\n'


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, text in (('leader', LEADER), ('follower', FOLLOWER), ('1:a,b', LEADER)):
        (tmp_path / f'{name}.py').write_text(text)


def velocities(scripts, nb_robots, poses=None):
    scripts.check(nb_robots)
    laws = [scripts.law(robot, nb_robots) for robot in range(1, nb_robots + 1)]
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
