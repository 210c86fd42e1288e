import numpy as np
import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_simu.robots.velocity_limits import limits_named


def test_ideal_robots_have_no_limits():
    V, omega = limits_named('ideal').saturate([3.0, -3.0], [20.0, -20.0])

    assert V.tolist() == [3.0, -3.0]
    assert omega.tolist() == [20.0, -20.0]


def test_burger_clamps_speed_and_turn_rate():
    V, omega = limits_named('burger').saturate([0.5, -0.5, 0.0], [0.0, 0.0, 9.0])

    np.testing.assert_allclose(V, [0.2108, -0.2108, 0.0])
    np.testing.assert_allclose(omega, [0.0, 0.0, 2.635])


def test_burger_clamps_each_wheel():
    V, omega = limits_named('burger').saturate([0.2108], [2.635])
    left, right = V - 0.08 * omega, V + 0.08 * omega

    np.testing.assert_allclose(left, [0.2108 - 0.08 * 2.635], atol=1e-12)
    np.testing.assert_allclose(right, [0.2667])


def test_unknown_limits_are_refused_with_the_known_ones():
    with pytest.raises(SetcmasError, match=r"'segway'; must be one of ideal, burger"):
        limits_named('segway')
