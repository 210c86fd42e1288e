import numpy as np

from setcmas_ctrl.control.acceleration import limited_rise


def test_speed_rises_by_so_much_and_falls_at_once():
    before = np.array([[0.1, 0.3, 0.2, 0.0], [0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]])
    wanted = np.array([[0.5, 0.1, -0.5, 0.12], [0.0, 0.0, 0.0, 0.16], [1.0, 2.0, 3.0, 4.0]])

    limited = limited_rise(wanted, before, 0.1)

    np.testing.assert_allclose(limited[0], [0.2, 0.1, -0.1, 0.06])
    np.testing.assert_allclose(limited[1], [0.0, 0.0, 0.0, 0.08])
    assert (limited[2] == wanted[2]).all()
