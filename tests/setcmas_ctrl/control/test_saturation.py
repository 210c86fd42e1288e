import numpy as np
import pytest

from setcmas_ctrl.control.saturation import dead_band, limited_rise, saturate


def test_speed_rises_by_so_much_and_falls_at_once():
    before = np.array([[0.1, 0.3, 0.2, 0.0], [0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]])
    wanted = np.array([[0.5, 0.1, -0.5, 0.12], [0.0, 0.0, 0.0, 0.16], [1.0, 2.0, 3.0, 4.0]])

    limited = limited_rise(wanted, before, 0.1)

    np.testing.assert_allclose(limited[0], [0.2, 0.1, -0.1, 0.06])
    np.testing.assert_allclose(limited[1], [0.0, 0.0, 0.0, 0.08])
    assert (limited[2] == wanted[2]).all()


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
