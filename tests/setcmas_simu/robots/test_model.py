import numpy as np
import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_simu.robots.model import limits_named


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
