import numpy as np

from setcmas_tools.records.fleet_table import fleet_table
from setcmas_tools.records.track import Track


def track(*rows):
    return Track(fleet_table([[t, 1, x, 0.0, theta, 0.5, 0.0] for t, x, theta in rows]))


def test_poses_turn_the_short_way_and_end_with_the_samples():
    poses = track((0.0, 0.0, 3.0), (0.5, 0.2, -3.0)).poses(np.array([-0.1, 0.0, 0.25, 0.5, 0.6]))

    np.testing.assert_allclose(poses[0], [np.nan, 0.0, 0.1, 0.2, np.nan])
    np.testing.assert_allclose(poses[2, 1:4], [3.0, np.pi, 2 * np.pi - 3.0])


def test_a_gap_is_broken_and_its_ends_are_not():
    one = track((0.0, 0.0, 0.0), (0.5, 0.2, 0.0), (4.0, 1.0, 0.0), (4.5, 1.2, 0.0))

    assert np.isnan(one.poses(np.array([0.6, 3.9]))).all()
    assert np.isfinite(one.poses(np.array([0.5, 4.0]))).all()
    assert not one.is_broken(0.0, 0.5)
    assert one.is_broken(0.4, 4.1)
    assert one.is_broken(1.0, 2.0)
    assert not one.is_broken(4.0, 4.5)
    assert (one.newest(3.0), one.next(3.0)) == (1, 2)
    assert (one.newest(-1.0), one.next(9.0)) == (-1, 4)


def test_a_robot_that_was_never_seen():
    one = track((0.0, np.nan, 0.0))

    assert np.isnan(one.poses(np.zeros(2))).all()
    assert not one.is_broken(0.0, 1.0)
