import numpy as np
import pytest

from setcmas_simu.robots.si_to_uni import si_to_uni


def test_forward_speed_is_the_norm_and_turn_rate_follows_the_heading_error():
    V, omega = si_to_uni([[0.3], [0.4]], [0.5], komega=2.0)

    assert pytest.approx(0.5) == V
    assert omega == pytest.approx(2.0 * (np.arctan2(0.4, 0.3) - 0.5))


def test_the_robot_turns_the_short_way():
    _, omega = si_to_uni([[-1.0, -1.0], [-0.1, 0.1]], [3.0, -3.0])

    assert 0 < omega[0] < 1.5
    assert -1.5 < omega[1] < 0


def test_a_robot_that_stands_does_not_turn():
    V, omega = si_to_uni([[0.005, 0.0], [0.0, 0.0]], [2.0, 1.0])

    assert omega.tolist() == [0.0, 0.0]
    assert V.tolist() == [0.005, 0.0]


def test_slow_turns_become_none():
    _, omega = si_to_uni([[1.0, 1.0], [0.0, 0.0]], [0.006, 0.008], komega=1.5)

    assert omega[0] == 0.0
    assert omega[1] == pytest.approx(-0.012)


def test_one_robot_alone_may_be_given_without_columns():
    V, omega = si_to_uni((0.0, 2.0), 0.0)

    assert float(V) == 2.0
    assert float(omega) == pytest.approx(1.5 * np.pi / 2)


def test_a_robot_stands_whose_velocity_or_heading_is_not_finite():
    nan, inf = np.nan, np.inf
    V, omega = si_to_uni([[nan, 1.0, inf, 0.3], [0.0, nan, 0.0, 0.0]], [0.0, 0.0, 0.0, nan])

    assert V.tolist() == [0.0] * 4
    assert omega.tolist() == [0.0] * 4
