import numpy as np
import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_simu.robots.model import limits_named, si_to_uni


def test_forward_speed_is_the_norm_and_turn_rate_follows_the_heading_error():
    V, omega = si_to_uni([[0.3], [0.4]], [0.5], komega=2.0)

    assert pytest.approx(0.5) == V
    assert omega == pytest.approx(2.0 * (np.arctan2(0.4, 0.3) - 0.5))


def test_the_robot_turns_the_short_way():
    _, omega = si_to_uni([[-1.0, -1.0], [-0.1, 0.1]], [3.0, -3.0])

    assert 0 < omega[0] < 1.5
    assert -1.5 < omega[1] < 0


def test_slow_robots_and_slow_turns_do_not_turn():
    V, omega = si_to_uni([[0.005, 0.0, 1.0, 1.0], [0.0] * 4], [2.0, 1.0, 0.006, 0.008], komega=1.5)

    assert V.tolist() == [0.005, 0.0, 1.0, 1.0]
    assert omega.tolist() == pytest.approx([0.0, 0.0, 0.0, -0.012])


def test_one_robot_alone_may_be_given_without_columns():
    V, omega = si_to_uni((0.0, 2.0), 0.0)

    assert float(V) == 2.0
    assert float(omega) == pytest.approx(1.5 * np.pi / 2)


def test_a_robot_stands_whose_velocity_or_heading_is_not_finite():
    nan, inf = np.nan, np.inf
    V, omega = si_to_uni([[nan, 1.0, inf, 0.3], [0.0, nan, 0.0, 0.0]], [0.0, 0.0, 0.0, nan])

    assert V.tolist() == [0.0] * 4
    assert omega.tolist() == [0.0] * 4


@pytest.mark.parametrize(
    ('name', 'reached'),
    [
        ('ideal', [[3.0, -3.0, 0.0], [0.0, 0.0, 20.0]]),
        ('burger', [[0.2108, -0.2108, 0.0], [0.0, 0.0, 2.635]]),
    ],
)
def test_limits_clamp_speed_and_turn_rate(name, reached):
    saturated = limits_named(name).saturate([3.0, -3.0, 0.0], [0.0, 0.0, 20.0])

    np.testing.assert_allclose(saturated, reached)


def test_burger_clamps_each_wheel():
    V, omega = limits_named('burger').saturate([0.2108], [2.635])
    left, right = V - 0.08 * omega, V + 0.08 * omega

    np.testing.assert_allclose(left, [0.2108 - 0.08 * 2.635], atol=1e-12)
    np.testing.assert_allclose(right, [0.2667])


def test_unknown_limits_are_refused_with_the_known_ones():
    with pytest.raises(SetcmasError, match=r"'segway'; must be one of ideal, burger"):
        limits_named('segway')
