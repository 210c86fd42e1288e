import numpy as np
import pytest

from setcmas_ctrl.robot_script import ScriptRobot
from setcmas_ctrl.si_to_uni import conversion_of
from setcmas_simu.errors import SetcmasError
from setcmas_simu.robots.unicycle import UNICYCLE

TS = 0.1

UNICYCLE_SCRIPT = """
from math import cos, sin

def step(state, command, Ts):
    x, y, theta = state
    V, left, omega = command
    theta = theta + Ts * omega
    return x + Ts * V * cos(theta), y + Ts * V * sin(theta), theta
"""

LAG = """
def start(x, y, theta):
    return x, y, theta, 0.0

def step(state, command, Ts):
    x, y, theta, V = state
    V += 0.5 * (command[0] - V)
    return x + Ts * V, y, theta, V
"""

SIDEWAYS = """
def step(state, command, Ts):
    x, y, theta = state
    return x + Ts * command[0], y + Ts * command[1], theta

def command(velocity, pose):
    return velocity[0], velocity[1], 0
"""


@pytest.fixture
def said():
    return []


@pytest.fixture
def robot(tmp_path, said):
    def load(text, number=2):
        path = tmp_path / 'my_robot.py'
        path.write_text(text)
        return ScriptRobot(path, number, said.append, lambda *_: None)

    return load


def command(*values):
    return np.array(values, dtype=float)[:, None]


POSE = np.array([[1.0], [2.0], [0.5]])


def test_a_script_moves_its_robot_as_the_same_model_does(robot):
    script = robot(UNICYCLE_SCRIPT)
    states, expected = script.start(POSE), UNICYCLE.start(POSE)
    assert conversion_of(script) is conversion_of(UNICYCLE)
    for _ in range(5):
        wanted = command(0.3, 0.0, -0.4)
        states, expected = script.step(states, wanted, TS), UNICYCLE.step(expected, wanted, TS)
        np.testing.assert_allclose(states, expected, atol=1e-12)


def test_a_state_may_be_more_than_a_pose_and_is_what_step_returned_last(robot):
    script = robot(LAG)
    states = script.start(POSE)
    for _ in range(3):
        states = script.step(states, command(0.8, 0, 0), TS)

    assert states[6, 0] == pytest.approx(0.7)
    assert states[0, 0] == pytest.approx(1.0 + TS * (0.4 + 0.6 + 0.7))
    assert script.start(POSE)[6, 0] == 0.0


def test_a_script_may_turn_velocities_into_commands_itself(robot):
    script = robot(SIDEWAYS)
    wanted = script.command(command(0.1, 0.2), np.zeros((3, 1)), 1.5)
    states = script.step(script.start(np.zeros((3, 1))), wanted, TS)

    np.testing.assert_allclose(wanted[:, 0], [0.1, 0.2, 0.0])
    np.testing.assert_allclose(states[:, 0], [0.01, 0.02, 0.0, 0.1, 0.2, 0.0])


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('def step(state, command, Ts):\n    return 1 / 0\n', 'my_robot.py, line 2: ZeroDivision'),
        (
            'def step(s, c, Ts):\n    return 1, 2\n',
            'step returned 2 values: (1, 2); it must return 3',
        ),
    ],
)
def test_a_robot_whose_script_fails_stands_and_is_reported_once(robot, said, text, message):
    script = robot(text)
    states = script.start(POSE)
    for _ in range(3):
        states = script.step(states, command(0.5, 0, 0), TS)

    assert states[:, 0].tolist() == [1.0, 2.0, 0.5, 0.0, 0.0, 0.0]
    assert len(said) == 1
    assert said[0].startswith('tb3_2 at t = 0.0 s: ')
    assert message in said[0]
    assert 'tb3_2 stops; the other robots continue' in said[0]
    assert script.failed


def test_a_command_that_fails_is_zero(robot, said):
    script = robot(SIDEWAYS.replace('velocity[0]', 'speed'))

    assert not script.command(command(0.1, 0.2), np.zeros((3, 1)), 1.5).any()
    assert "name 'speed' is not defined" in said[0]


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        (
            'def control(a, b, c, d): pass',
            r'its control is for --algo .* have step\(state, command, Ts',
        ),
        ('def step(state): pass', 'does not take three arguments'),
        ('def step(s, c, t): pass\ncommand = 3', 'has no function command'),
    ],
)
def test_scripts_that_cannot_be_loaded_are_reported(robot, text, message):
    with pytest.raises(SetcmasError, match=message):
        robot(text)


def test_a_start_that_fails_is_reported(robot):
    script = robot('def step(s, c, t): pass\ndef start(x, y, theta): return x / 0')
    with pytest.raises(SetcmasError, match='line 2: ZeroDivisionError'):
        script.start(POSE)
    with pytest.raises(
        SetcmasError, match=r'line 2: start returned 1 value: 1\.0; it must return 3 or'
    ):
        robot('def step(s, c, t): pass\ndef start(x, y, theta): return x').start(POSE)
