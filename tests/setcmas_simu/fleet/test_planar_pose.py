import numpy as np
import pytest

from setcmas_simu.fleet.planar_pose import (
    quaternion_of_yaw,
    through_quaternion,
    wrap_angle,
    yaw_of_quaternion,
)


def test_wrap_angle_keeps_direction_and_interval():
    angles = np.linspace(-50, 50, 1001)
    wrapped = wrap_angle(angles)

    assert ((wrapped > -np.pi) & (wrapped <= np.pi)).all()
    assert wrap_angle([-np.pi, np.pi]).tolist() == [np.pi, np.pi]
    np.testing.assert_allclose(np.exp(1j * wrapped), np.exp(1j * angles), atol=1e-9)


@pytest.mark.parametrize('yaw', np.linspace(-3.1, 3.1, 13))
def test_quaternion_round_trip(yaw):
    z, w = quaternion_of_yaw(yaw)

    assert yaw_of_quaternion(0.0, 0.0, z, w) == pytest.approx(yaw)
    assert yaw_of_quaternion(0.0, 0.0, 5 * z, 5 * w) == pytest.approx(yaw)


def test_a_fleet_and_a_single_robot_have_the_same_heading_to_the_last_bit():
    theta = np.random.default_rng(0).uniform(-30, 30, 1001)
    theta[0] = -0.0
    together = through_quaternion(np.stack([theta, theta, theta]))[2]
    single = [yaw_of_quaternion(0.0, 0.0, *quaternion_of_yaw(one)) for one in theta.tolist()]
    by_column = [
        through_quaternion(np.array([[0.0], [0.0], [one]]))[2, 0] for one in theta.tolist()
    ]

    assert together.tobytes() == np.array(single).tobytes() == np.array(by_column).tobytes()
    np.testing.assert_allclose(together, wrap_angle(theta), atol=1e-14)
