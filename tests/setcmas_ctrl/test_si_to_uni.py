import math

import numpy as np
import pytest

from setcmas_ctrl.si_to_uni import conversion_of, si_to_uni
from setcmas_simu.robots.car import CAR
from setcmas_simu.robots.omnidirectional import OMNIDIRECTIONAL
from setcmas_simu.robots.unicycle import UNICYCLE
from setcmas_tools import simulate


def test_forward_speed_is_the_norm_and_turn_rate_follows_the_heading_error():
    V, omega = si_to_uni([[0.3], [0.4]], [0.5], komega=2.0)

    assert pytest.approx(0.5) == V
    assert omega == pytest.approx(2.0 * (np.arctan2(0.4, 0.3) - 0.5))


def test_the_robot_turns_the_short_way():
    _, omega = si_to_uni([[-1.0, -1.0], [-0.1, 0.1]], [3.0, -3.0], 1.5)

    assert 0 < omega[0] < 1.5
    assert -1.5 < omega[1] < 0


def test_slow_robots_and_slow_turns_do_not_turn():
    V, omega = si_to_uni([[0.005, 0.0, 1.0, 1.0], [0.0] * 4], [2.0, 1.0, 0.006, 0.008], komega=1.5)

    assert V.tolist() == [0.005, 0.0, 1.0, 1.0]
    assert omega.tolist() == pytest.approx([0.0, 0.0, 0.0, -0.012])


def test_one_robot_alone_may_be_given_without_columns():
    V, omega = si_to_uni((0.0, 2.0), 0.0, 1.5)

    assert float(V) == 2.0
    assert float(omega) == pytest.approx(1.5 * np.pi / 2)


def test_a_robot_stands_whose_velocity_or_heading_is_not_finite():
    nan, inf = np.nan, np.inf
    V, omega = si_to_uni([[nan, 1.0, inf, 0.3], [0.0, nan, 0.0, 0.0]], [0.0, 0.0, 0.0, nan], 1.5)

    assert V.tolist() == [0.0] * 4
    assert omega.tolist() == [0.0] * 4


@pytest.mark.parametrize('model', [UNICYCLE, CAR, OMNIDIRECTIONAL])
@pytest.mark.parametrize('velocity', [(math.nan, 0.0), (0.3, math.inf)])
def test_a_velocity_that_is_not_finite_becomes_zero(model, velocity):
    velocities = np.array([[velocity[0], 0.2], [velocity[1], 0.0]])
    commands = conversion_of(model)(velocities, np.zeros((3, 2)), 1.5)

    assert commands[:, 0].tolist() == [0.0, 0.0, 0.0]
    assert commands[:, 1].tolist() == [0.2, 0.0, 0.0]


def test_velocities_have_the_precision_of_messages():
    def third(robotNo, nbRobots, poses, t):
        return 1 / 3, 0.0

    run = simulate(third, 1, 1.0, poses=np.zeros((3, 1)))

    assert run.commands.vx[0] == np.float32(1 / 3)
    assert run.poses[-1, 0, 0] == pytest.approx(float(np.float32(1 / 3)), abs=1e-15)
