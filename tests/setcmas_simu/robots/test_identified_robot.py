import math

import numpy as np
import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_simu.robots.identified_robot import (
    IdentifiedRobot,
    ModelFile,
    Response,
    read_model_file,
    write_model_file,
)
from setcmas_simu.robots.model import ROBOT_LIMITS
from setcmas_simu.robots.models_by_name import check_models, fastest, robot_models

SLOW = Response(0.9, 0.15, 0.2)
QUICK = Response(1.05, 0.0, 0.1)


@pytest.fixture
def path(tmp_path):
    return tmp_path / 'model.yaml'


def test_what_is_written_is_read(path):
    burger = ROBOT_LIMITS['burger']
    robot = IdentifiedRobot(SLOW, QUICK, burger)
    write_model_file(ModelFile({2: robot}, None, 'burger'), path, 'of a test')

    read = read_model_file(path).robot(2)

    assert (read.forward, read.turn, read.limits) == (SLOW, QUICK, burger)
    assert path.read_text().startswith('# of a test\n')


def test_robots_that_are_not_named_are_the_others(path):
    path.write_text('robots:\n  1: {forward: {lag: 0.3}}\nothers: {turn: {delay: 0.1}}\n')

    assert read_model_file(path).robot(1).forward == Response(lag=0.3)
    seventh, eighth = robot_models([str(path)] * 2, [7, 8])
    assert seventh.turn == Response(delay=0.1)
    assert eighth is seventh


def test_each_robot_of_a_fleet_has_its_own(path):
    path.write_text('limits: burger\nrobots:\n  1: {forward: {lag: 0.3}}\n  3: {}\n')

    first, second, third = robot_models([str(path), 'burger', str(path)], [1, 2, 3])

    assert first.forward.lag == 0.3
    assert third.forward.lag == 0.0
    assert second.limits is first.limits
    assert fastest(f'1,3:{path}', 3, 'ideal') == float('inf')  # robot 2 is a unicycle
    with pytest.raises(SetcmasError, match='has no model of tb3_2, only of tb3_1, tb3_3'):
        check_models([str(path)] * 3, 'ideal')


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('robots: {1: {forward: {lag: -1}}}', 'line 1: robots.1.forward.lag is -1; it must be'),
        ('robots: {1: {forward: {gain: 0}}}', 'gain is 0; it must be above 0 and at most 10'),
        ('robots: {1: {turn: {delay: 3}}}', 'delay is 3; it must be from 0 to 2 s'),
        ('robots: {1: {speed: {}}}', "there is no key 'robots.1.speed'; it must be one of"),
        ('robots: {0: {}}', "invalid robot '0'; must be a whole number from 1"),
        ('robots: 3', 'robots is 3; it must be a mapping'),
        ('limits: fast\nothers: {}', "limits is 'fast'; it must be ideal, burger"),
        ('', "has no robots; add 'robots' or 'others'"),
        ('a: [', 'not YAML'),
    ],
)
def test_a_mistake_is_reported_in_one_line(path, text, message):
    path.write_text(text)

    with pytest.raises(SetcmasError) as caught:
        read_model_file(path)
    assert message in str(caught.value)
    assert '\n' not in str(caught.value)


FORWARD = Response(gain=0.9, lag=0.3, delay=0.25)
TURN = Response(gain=1.1, lag=0.0, delay=0.17)


def after(model, seconds, Ts, commands):
    """Return the state of a robot; commands are (V, omega), the last one held."""
    state = model.start(np.zeros((3, 1)))
    for step in range(round(seconds / Ts)):
        V, omega = commands[min(step, len(commands) - 1)]
        state = model.step(state, np.array([[V], [0.0], [omega]]), Ts)
    return state[:, 0]


@pytest.mark.parametrize('Ts', [0.1, 0.05, 0.013, 0.01])
def test_a_step_is_answered_with_gain_lag_and_delay_at_any_rate(Ts):
    state = after(IdentifiedRobot(FORWARD, TURN), 104 * Ts, Ts, [(0.2, 0.5)])

    elapsed = 104 * Ts
    assert state[6] == pytest.approx(0.9 * 0.2 * -math.expm1(-(elapsed - 0.25) / 0.3))
    assert state[2] == pytest.approx(1.1 * 0.5 * (elapsed - 0.17))


def test_the_way_is_the_integral_of_the_speed():
    state = after(IdentifiedRobot(FORWARD, TURN), 2.0, 0.1, [(0.2, 0.0)])

    t = 2.0 - 0.25
    assert state[0] == pytest.approx(0.9 * 0.2 * (t - 0.3 * -math.expm1(-t / 0.3)))


@pytest.mark.parametrize('rate', [50, 100, 200])
def test_a_command_that_changes_at_each_step_is_remembered_for_the_longest_delay(rate):
    slow = IdentifiedRobot(Response(delay=2.0), Response(delay=2.0))
    commands = [(0.01 * step, 0.0) for step in range(4 * rate)]

    state = after(slow, 3.0, 1 / rate, commands)

    assert state[3] == pytest.approx(0.01 * (rate - 1))


def test_robots_of_one_model_do_not_mix():
    model = IdentifiedRobot(FORWARD, TURN)
    state = model.start(np.zeros((3, 2)))
    for step in range(20):
        state = model.step(state, np.array([[0.2, 0.0], [0.0, 0.0], [0.1 * step, 0.0]]), 0.1)
    assert state[0, 0] > 0.1
    assert not state[:3, 1].any()


def test_commands_are_slowed_down_on_the_same_curve():
    burger = ROBOT_LIMITS['burger']
    model = IdentifiedRobot(Response(), Response(), burger)

    state = after(model, 0.1, 0.1, [(0.5, 0.75 * math.pi)])

    assert state[3::2][:2] == pytest.approx(burger.scaled_down(0.5, 0.75 * math.pi))
