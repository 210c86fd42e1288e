import numpy as np
import pytest

from setcmas_simu.robots import unicycle
from setcmas_simu.robots.unicycle import step, velocities_between
from setcmas_tools import simulate


def test_robots_move_each_on_its_own_and_other_rows_stay():
    states = np.arange(12.0).reshape(4, 3)

    later = step(states, np.array([1.0, 0.0, -1.0]), np.array([0.0, 2.0, 0.0]), 0.5)

    np.testing.assert_array_equal(later[2:], [[6.0, 8.0, 8.0], [9.0, 10.0, 11.0]])
    np.testing.assert_allclose(later[0], [0.5 * np.cos(6.0), 1.0, 2.0 - 0.5 * np.cos(8.0)])
    np.testing.assert_array_equal(states, np.arange(12.0).reshape(4, 3))


@pytest.mark.parametrize(('V', 'omega'), [(0.3, 0.7), (-0.2, 6.0), (0.5, 0.0), (0.0, -2.0)])
def test_velocities_between_inverts_step(V, omega):
    before = np.array([1.0, -2.0, 3.0])

    found = velocities_between(before, step(before, V, omega, 0.1), 0.1)

    np.testing.assert_allclose(found, (V, omega), atol=1e-12)


@pytest.mark.parametrize('model', ['unicycle', 'car', 'burger'])
def test_an_edit_of_step_is_seen_in_a_run(model, monkeypatch):
    def twice_as_far(states, V, omega, Ts):
        return step(states, 2 * V, omega, Ts)

    def ahead(robotNo, nbRobots, poses, t):
        return 0.1, 0.0

    def way():
        run = simulate(ahead, 2, 2.0, model=model, poses=[[0, 0], [0, 1], [0, 0]])
        return run.poses[-1, 0]

    before = way()
    monkeypatch.setattr(unicycle, 'step', twice_as_far)

    np.testing.assert_allclose(way(), 2 * before)
