import math

import numpy as np
import pytest

from setcmas_tools.view.model.fleet_view import FORGOTTEN_S, LOST_S, FleetView


def test_motion_is_smooth_one_period_behind():
    view = FleetView()
    view.see(2, (0.0, 0.0, 0.0), 0.5, 10.0)
    view.see(2, (0.02, 0.04, 0.4), 0.5, 10.1)

    np.testing.assert_allclose(view.poses(10.1)[:, 0], (0.0, 0.0, 0.0), atol=1e-9)
    np.testing.assert_allclose(view.poses(10.15)[:, 0], (0.01, 0.02, 0.2), atol=1e-9)
    np.testing.assert_allclose(view.poses(10.3)[:, 0], (0.02, 0.04, 0.4), atol=1e-9)
    np.testing.assert_allclose(view.newest()[:, 0], (0.02, 0.04, 0.4))


def test_headings_turn_the_short_way():
    view = FleetView()
    view.see(1, (0.0, 0.0, 3.0), 0.0, 0.0)
    view.see(1, (0.0, 0.0, -3.0), 0.0, 0.1)

    assert abs(view.poses(0.15)[2, 0]) == pytest.approx(math.pi)


def test_a_robot_that_is_put_elsewhere_is_there_at_once():
    view = FleetView()
    view.see(1, (0.0, 0.0, 0.0), 0.0, 0.0)
    assert view.take_put() == {1}
    view.see(1, (0.04, 0.0, 0.0), 0.0, 0.1)
    assert not view.take_put()
    view.see(1, (0.5, 0.0, 1.0), 0.0, 0.2)

    assert view.take_put() == {1}
    np.testing.assert_allclose(view.poses(0.2)[:, 0], (0.5, 0.0, 1.0))


def test_silent_robots_are_lost_and_later_forgotten():
    view = FleetView()
    view.see(3, (0.0, 0.0, 0.0), 0.0, 0.0)
    view.see(1, (1.0, 0.0, 0.0), 0.2, 0.0)
    view.see(1, (1.0, 0.0, 0.0), 0.3, LOST_S)

    assert view.robots == [1, 3]
    assert view.lost(LOST_S + 0.1).tolist() == [False, True]
    assert view.speeds().tolist() == [0.3, 0.0]
    view.forget(FORGOTTEN_S + 0.1)
    assert view.robots == [1]


def test_poses_that_are_not_finite_are_passed_over():
    view = FleetView()
    view.see(1, (math.nan, 0.0, 0.0), 0.0, 0.0)

    assert view.robots == []
    assert view.poses(0.0).shape == (3, 0)


def test_disagreement_of_the_robots_that_are_there():
    view = FleetView()
    assert view.disagreement(view.lost(0.0)) is None
    for robot, x in ((1, 0.0), (2, 2.0), (3, 50.0)):
        view.see(robot, (x, 0.0, 0.0), 0.0, 0.0 if robot == 3 else 1.0)

    assert view.disagreement(view.lost(LOST_S + 0.5)) == pytest.approx(1.0)
