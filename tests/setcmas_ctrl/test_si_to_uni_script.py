import math
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest

import setcmas_ctrl.templates
from setcmas_ctrl.laws.script_errors import ErrorReports
from setcmas_ctrl.si_to_uni import as_unicycles
from setcmas_ctrl.si_to_uni_script import ScriptConversion, script_conversions
from setcmas_simu.errors import SetcmasError
from setcmas_tools import Scenario, simulate

TEMPLATE = Path(setcmas_ctrl.templates.__file__).parent / 'si_to_uni.py'
AHEAD = """
from math import cos, sin

def si_to_uni(velocity, pose, komega):
    vx, vy = velocity
    x, y, theta = pose
    return vx * cos(theta) + vy * sin(theta), (vy * cos(theta) - vx * sin(theta)) / 0.2
"""


@pytest.fixture
def said():
    return []


@pytest.fixture
def conversion(tmp_path, said):
    def load(text, robot=2):
        path = tmp_path / 'mine.py'
        path.write_text(text)
        reports = ErrorReports(said.append)
        return ScriptConversion(path, robot, reports, lambda: 1.2, lambda *_: nullcontext())

    return load


def velocity(vx=0.3, vy=-0.4):
    return np.array([[vx], [vy]])


def pose(theta=0.5):
    return np.array([[1.0], [2.0], [theta]])


def test_the_script_to_start_from_is_the_built_in_si_to_uni(conversion):
    random = np.random.default_rng(1)
    velocities = random.uniform(-0.5, 0.5, (2, 500)) * random.choice([1.0, 0.02, 0.0], 500)
    poses = random.uniform(-9.0, 9.0, (3, 500))
    poses[2, ::3] = np.arctan2(velocities[1], velocities[0])[::3] + 0.004  # hardly turns

    commands = conversion(TEMPLATE.read_text())(velocities, poses, 1.5)

    np.testing.assert_allclose(commands, as_unicycles(velocities, poses, 1.5), rtol=0, atol=1e-14)


def test_it_gets_velocity_pose_and_gain(conversion):
    convert = conversion('def si_to_uni(v, pose, komega):\n    return v[1] + komega, pose[2]\n')

    assert convert(velocity(), pose(), 2.0)[:, 0].tolist() == [1.6, 0.0, 0.5]


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('    return 1 / 0\n', 'mine.py, line 2: ZeroDivisionError'),
        ('    return 0.1, 0.2, 0.3\n', 'it must return two finite numbers: return V, omega'),
    ],
)
def test_a_robot_whose_conversion_fails_is_commanded_zero_and_reported_once(
    conversion, said, text, message
):
    convert = conversion(f'def si_to_uni(velocity, pose, komega):\n{text}')
    for _ in range(3):
        assert not convert(velocity(), pose(), 1.5).any()

    (line,) = said
    assert line.startswith('tb3_2 at t = 1.2 s: ')
    assert message in line
    assert 'tb3_2 gets zero velocity; the other robots continue' in line


@pytest.mark.parametrize(
    'unknown', [(velocity(vx=math.nan), pose()), (velocity(), pose(math.nan))]
)
def test_a_robot_without_a_velocity_or_a_pose_stands_and_its_script_is_not_called(
    conversion, said, unknown
):
    convert = conversion('def si_to_uni(velocity, pose, komega):\n    return 1 / 0\n')

    assert not convert(*unknown, 1.5).any()
    assert said == []


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('x = 1', r'no function si_to_uni; it must have si_to_uni\(velocity, pose, komega\)'),
        ('def si_to_uni(v, p, k):\n    yield 1', 'ends with return V, omega'),
    ],
)
def test_scripts_that_cannot_be_loaded_are_reported(conversion, text, message):
    with pytest.raises(SetcmasError, match=message):
        conversion(text)


def test_every_robot_has_its_own_copy_or_function(tmp_path, said):
    path = tmp_path / 'count.py'
    path.write_text('n = 0\ndef si_to_uni(v, p, k):\n    global n\n    n += 1\n    return n, 0\n')
    watch = ErrorReports(said.append), lambda: 0.0, lambda *_: nullcontext()

    of_script = script_conversions(path, [1, 2], *watch)
    of_functions = script_conversions({i: lambda *_, i=i: (i, 0) for i in (1, 2)}, [1, 2], *watch)

    assert [one(velocity(), pose(), 1.5)[0, 0] for one in (*of_script, of_script[0])] == [1, 1, 2]
    assert [one(velocity(), pose(), 1.5)[0, 0] for one in of_functions] == [1, 2]
    assert script_conversions(None, [1, 2], *watch) == []


def towards_y(robotNo, nbRobots, poses, t):
    return 0.0, 0.3


START = np.array([[0.0, 1.0], [0.0, 0.0], [0.0, math.pi]])


def test_robots_of_a_run_are_driven_by_it(tmp_path):
    (tmp_path / 'ahead.py').write_text(AHEAD)
    scenario = Scenario.of(towards_y, nb_robots=2, duration=8, poses=START)

    run = simulate(scenario.replace(si_to_uni=tmp_path / 'ahead.py'))

    # The point ahead of the axle goes where the law wants it, from its start on.
    x, y, theta = run.poses[-1]
    np.testing.assert_allclose(x + 0.2 * np.cos(theta), [0.2, 0.8], atol=0.1)
    np.testing.assert_allclose(y + 0.2 * np.sin(theta), [2.4, 2.4], atol=0.1)
    assert run.info.scenario['si_to_uni'] == 'inputs/si_to_uni/ahead.py'


def test_failures_of_a_run_are_kept():
    def fails_late(velocity, pose, komega):
        return 1 / (pose[2] > 1.0), 0.0

    said = []
    scenario = Scenario.of(towards_y, nb_robots=2, duration=1, poses=START)
    run = simulate(scenario, si_to_uni=fails_late, warn=said.append)

    (failure,) = run.info.failures
    assert (failure.t, failure.robot, failure.function.value) == (0.0, 1, 'si_to_uni')
    assert run.outcome.failed == {Path(__file__).name: [1]}
    assert len(said) == 1


@pytest.mark.parametrize('name', ['none', 'none.py'])
def test_a_missing_script_is_refused(name):
    with pytest.raises(SetcmasError, match=f"script '{name}' of --si-to-uni not found"):
        simulate(Scenario.of('consensus', nb_robots=2, duration=1), si_to_uni=name)
