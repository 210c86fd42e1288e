import numpy as np
import pytest

from setcmas_simu.robots.unicycle import step, velocities_between


def test_heading_is_integrated_before_position():
    poses = step([[0.0], [0.0], [0.0]], [1.0], [np.pi / 2 / 0.1], 0.1)

    np.testing.assert_allclose(poses[:, 0], [0.0, 0.1, np.pi / 2], atol=1e-12)


def test_a_circle_closes():
    poses = np.zeros((3, 1))
    for _ in range(400):
        poses = step(poses, [0.5], [2 * np.pi / 40], 0.1)

    np.testing.assert_allclose(poses[:2, 0], [0.0, 0.0], atol=1e-9)


@pytest.mark.parametrize(('V', 'omega'), [(0.3, 0.7), (-0.2, 6.0), (0.5, 0.0), (0.0, -2.0)])
def test_velocities_between_inverts_step(V, omega):
    before = np.array([1.0, -2.0, 3.0])

    found = velocities_between(before, step(before, V, omega, 0.1), 0.1)

    np.testing.assert_allclose(found, (V, omega), atol=1e-12)
