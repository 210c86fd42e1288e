import numpy as np
import pytest

from setcmas_ctrl.saturation import dead_band, saturate


def test_fast_velocities_are_scaled_without_turning_each_column_on_its_own():
    np.testing.assert_allclose(saturate((3.0, -4.0), 0.5), [0.3, -0.4])
    velocities = saturate([[0.0, 10.0, 0.1], [0.0, 0.0, 0.2]], 1.0)

    np.testing.assert_allclose(velocities, [[0.0, 1.0, 0.1], [0.0, 0.0, 0.2]])


@pytest.mark.parametrize(
    ('velocity', 'expected'),
    [((0.009, 0.0), (0.0, 0.0)), ((0.008, 0.008), (0.008, 0.008)), ((0.0, -1.0), (0.0, -1.0))],
)
def test_dead_band(velocity, expected):
    assert dead_band(*velocity) == expected
