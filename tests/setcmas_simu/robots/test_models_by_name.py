import math

import numpy as np
import pytest
from plugins import add_plugins

from setcmas_simu.errors import SetcmasError
from setcmas_simu.robots.car import CAR, SMALLEST_RADIUS
from setcmas_simu.robots.model import POSE, TWIST, RobotModel
from setcmas_simu.robots.models_by_name import (
    MODELS,
    check_models,
    fleet_model,
    model_names,
    robot_models,
)
from setcmas_simu.robots.omnidirectional import OMNIDIRECTIONAL
from setcmas_simu.robots.turtlebot3 import LAG_S, WHEEL_ACCELERATION
from setcmas_simu.robots.unicycle import BURGER_SHAPE, UNICYCLE
from setcmas_tools import simulate


class Hovercraft(RobotModel):
    shape = BURGER_SHAPE
    V_max = 1.0

    def step(self, states, commands, Ts):
        del commands, Ts
        later = states.copy()
        later[0] += 0.1
        return later


def test_a_model_of_a_package_moves_as_it_says(monkeypatch):
    add_plugins(monkeypatch, MODELS, hovercraft=Hovercraft())

    run = simulate('consensus', 2, 2, model='1:hovercraft')

    assert run.outcome.state.value == 'complete'
    assert run.poses[-1, 0, 0] - run.poses[0, 0, 0] == pytest.approx(2.0)


TS = 0.1
SHIPPED = ['unicycle', 'burger', 'waffle', 'omnidirectional', 'car']


def moved(model, pose, command, steps=1):
    """Return pose and twist of one robot that follows a command for some periods."""
    states = model.start(np.array(pose, dtype=float).reshape(3, 1))
    for _ in range(steps):
        states = model.step(states, np.array(command, dtype=float).reshape(3, 1), TS)
    return states[POSE, 0], states[TWIST, 0]


def test_these_models_ship():
    assert {name for name, plugin in MODELS.plugins().items() if plugin.built_in} == {*SHIPPED}


@pytest.mark.parametrize('name', SHIPPED)
def test_a_robot_that_is_commanded_zero_stands(name):
    pose, twist = moved(MODELS.get(name), (1.0, 2.0, 0.5), (0.0, 0.0, 0.0))

    assert pose.tolist() == [1.0, 2.0, 0.5]
    assert not twist.any()


@pytest.mark.parametrize('name', SHIPPED)
def test_a_step_leaves_the_states_that_it_is_given(name):
    model = MODELS.get(name)
    states = model.start(np.zeros((3, 2)))
    model.step(states, np.ones((3, 2)), TS)

    assert not states.any()


@pytest.mark.parametrize('name', SHIPPED)
def test_outlines_have_the_front_ahead_and_bodies_are_convex(name):
    shape = MODELS.get(name).shape

    assert max(shape.outline)[1] == 0.0 or max(x for x, _ in shape.outline) > 0
    edges = np.roll(shape.body, -1, axis=0) - shape.body
    after = np.roll(edges, -1, axis=0)
    assert (edges[:, 0] * after[:, 1] - edges[:, 1] * after[:, 0] > -1e-12).all()


@pytest.mark.parametrize(('name', 'fastest'), [('burger', 0.2108), ('waffle', 0.2661)])
def test_a_turtlebot3_speeds_up_no_faster_than_its_wheels_and_reaches_its_limit(name, fastest):
    model = MODELS.get(name)
    _, first = moved(model, (0, 0, 0), (5.0, 0.0, 0.0))
    pose, last = moved(model, (0, 0, 0), (5.0, 0.0, 0.0), steps=50)

    assert first[0] == pytest.approx(WHEEL_ACCELERATION * TS)
    assert last[0] == pytest.approx(fastest)
    assert model.V_max == fastest
    assert 0.0 < pose[0] < 50 * TS * fastest


def test_a_turtlebot3_follows_small_steps_with_its_lag():
    _, twist = moved(MODELS.get('burger'), (0, 0, 0), (0.05, 0.0, 0.2))

    reached = 1 - math.exp(-TS / LAG_S)
    np.testing.assert_allclose(twist, [0.05 * reached, 0.0, 0.2 * reached])


def test_an_omnidirectional_robot_goes_where_it_is_asked_to_and_keeps_its_heading():
    poses = np.array([[0.0, 1.0], [0.0, 1.0], [0.0, 2.0]])
    velocities = np.array([[0.0, -0.3], [0.5, 0.4]])
    commands = OMNIDIRECTIONAL.command(velocities, poses, 1.5)
    states = OMNIDIRECTIONAL.step(OMNIDIRECTIONAL.start(poses), commands, TS)

    np.testing.assert_allclose(states[:2], poses[:2] + TS * velocities)
    np.testing.assert_array_equal(states[2], poses[2])
    np.testing.assert_allclose(commands[:, 0], [0.0, 0.5, 0.0])


def test_a_car_turns_on_a_circle_of_its_smallest_radius_and_not_on_the_spot():
    half_turn = round(math.pi * SMALLEST_RADIUS / 0.5 / 0.001)
    states = CAR.start(np.zeros((3, 1)))
    for _ in range(half_turn):
        states = CAR.step(states, np.array([[0.5], [0.0], [9.0]]), 0.001)

    assert states[1, 0] == pytest.approx(2 * SMALLEST_RADIUS, rel=0.01)
    assert states[2, 0] == pytest.approx(math.pi, rel=0.01)
    assert moved(CAR, (0, 0, 0), (0.0, 0.0, 9.0))[0].tolist() == [0.0, 0.0, 0.0]


def test_robots_of_a_mixed_fleet_move_as_those_of_their_models():
    models = [UNICYCLE, CAR, UNICYCLE, OMNIDIRECTIONAL]
    fleet = fleet_model(models)
    poses = np.array([[0.0, 1, 2, 3], [0, 0, 0, 0], [0, 1, 2, 3]])
    commands = np.array([[0.1, 0.2, -0.3, 0.4], [0.1, -0.1, 0.2, 0.0], [0.5, 0.9, -1.0, 0.2]])
    states = fleet.step(fleet.start(poses), commands, TS)

    for i, model in enumerate(models):
        one = slice(i, i + 1)
        alone = model.step(model.start(poses[:, one]), commands[:, one], TS)
        np.testing.assert_array_equal(states[:, one], alone)
    assert fleet_model([CAR, CAR]) is CAR


@pytest.mark.parametrize(
    ('text', 'names'),
    [
        (None, ['unicycle'] * 3),
        ('car', ['car'] * 3),
        ('2:car', ['unicycle', 'car', 'unicycle']),
    ],
)
def test_names_of_models(text, names):
    assert model_names(text, 3) == names


def test_a_model_of_a_robot_outside_the_fleet_is_refused():
    with pytest.raises(SetcmasError, match='--model names robot 4; the fleet has robots 1 to 3'):
        model_names('4:car', 3)


def test_models_that_do_not_exist_and_limits_of_other_models_are_refused():
    with pytest.raises(SetcmasError, match="unknown robot model 'cars'"):
        check_models(['cars'], 'ideal')
    with pytest.raises(SetcmasError, match=r"robot script 'none\.py' not found"):
        check_models(['none.py'], 'ideal')
    with pytest.raises(
        SetcmasError, match="'burger' is for unicycles, but the model makes robot 2 car"
    ):
        check_models(['unicycle', 'car'], 'burger')
    check_models(['unicycle'], 'burger')


def test_unicycles_alone_have_the_limits_that_are_asked_for():
    unicycle, car = robot_models(['unicycle', 'car'], [1, 2], 'burger')

    assert unicycle.V_max == 0.2108
    assert car is CAR
