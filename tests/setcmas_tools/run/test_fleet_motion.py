import numpy as np
import pytest
from runs import measure

from setcmas_tools.run.fleet_motion import Track, fleet_table, on_grid, resets


def table(*robots):
    """A table of robots, each given as (times, x, theta)."""
    rows = [
        [t, number, x, -x, theta, 0, 0]
        for number, columns in enumerate(robots, start=1)
        for t, x, theta in zip(*columns, strict=True)
    ]
    return fleet_table(rows)


def test_robots_with_different_times_meet_on_the_grid():
    t1, t2 = np.arange(0, 2, 0.1), np.arange(0.03, 2, 0.1)
    grid = on_grid(table((t1, 2 * t1, 0 * t1), (t2, 5 - t2, 0 * t2)), rate=10)

    np.testing.assert_allclose(grid.t[:3], [0.0, 0.1, 0.2])
    assert grid.x.shape == (2, len(grid.t))
    np.testing.assert_allclose(grid.x[0, 1:19], 2 * grid.t[1:19])
    np.testing.assert_allclose(grid.y[1, 1:19], grid.t[1:19] - 5)
    assert np.isnan(grid.x[1, 0])


def test_headings_are_interpolated_the_short_way_round():
    grid = on_grid(table(([0.0, 1.0], [0, 0], [3.0, -3.0])), rate=2)

    np.testing.assert_allclose(grid.theta[0], [3.0, np.pi, 2 * np.pi - 3.0])


def test_nothing_is_made_up_in_gaps_and_lost_poses():
    t = np.array([0.0, 0.5, 1.0, 4.0, 4.5])
    x = np.array([0.0, np.nan, 1.0, 4.0, 4.5])
    grid = on_grid(table((t, x, 0 * t)), rate=2)

    np.testing.assert_allclose(grid.x[0, :3], [0.0, 0.5, 1.0])
    assert np.isnan(grid.x[0, 3:8]).all()
    np.testing.assert_allclose(grid.x[0, 8:], [4.0, 4.5])


def test_complete_until_a_robot_is_missed():
    t = np.arange(0, 10, 0.1)
    late, gone, broken = t[t > 4], t[t < 6], t[(t < 7) | (t > 8.5)]
    grid = on_grid(table((t, t, t), (late, late, late), (gone, gone, gone), (broken,) * 3))
    at = {
        round(float(time), 1): bool(yes) for time, yes in zip(grid.t, grid.complete, strict=True)
    }

    assert at[2.0]
    assert not at[3.5]
    assert at[5.0]
    assert not at[6.5]
    assert not at[7.5]
    assert at[9.5]


T = np.arange(0, 10, 0.1)


def driven(x, v=0.5):
    columns = np.broadcast_arrays(T, 1, x, 0.0, 0.0, v, 0.0)
    return fleet_table(np.transpose(columns))


@pytest.fixture
def put_back():
    """A robot at 0.5 m/s that is put back to its start after 5 s."""
    return driven(np.where(T < 5, 0.5 * T, 0.5 * (T - 5)))


def test_a_reset_is_no_way(put_back):
    motion = measure(put_back)['robots'][1]

    assert np.flatnonzero(resets(put_back)) == [np.searchsorted(T, 4.95) - 1]
    assert motion['path_length_m'] == pytest.approx(4.9)
    assert motion['mean_speed_m_s'] <= motion['largest_speed_m_s']


@pytest.mark.parametrize('rate', [25.0, 10.0, 2.0])
def test_no_line_joins_the_poses_before_and_after_a_reset(put_back, rate):
    steps = np.diff(on_grid(put_back, rate).x[0])

    assert np.nanmin(steps) > 0
    assert np.nanmax(steps) == pytest.approx(0.5 / rate)


def test_a_distance_that_can_be_driven_is_no_reset():
    noise = 0.02 * np.random.default_rng(0).normal(size=len(T))
    assert not resets(driven(0.5 * T + noise)).any()
    assert not resets(driven(3 * T, v=3.0)).any()
    assert not resets(driven(50 * T, v=0.0)).any()  # its odometry has no speed
    assert not resets(driven(5 * T, v=0.01)).any()  # sideways


def track(*rows):
    return Track(fleet_table([[t, 1, x, 0.0, theta, 0.5, 0.0] for t, x, theta in rows]))


def test_a_gap_is_broken_and_its_ends_are_not():
    one = track((0.0, 0.0, 0.0), (0.5, 0.2, 0.0), (4.0, 1.0, 0.0), (4.5, 1.2, 0.0))

    assert np.isnan(one.poses(np.array([0.6, 3.9]))).all()
    assert np.isfinite(one.poses(np.array([0.5, 4.0]))).all()
    assert not one.is_broken(0.0, 0.5)
    assert one.is_broken(0.4, 4.1)
    assert one.is_broken(1.0, 2.0)
    assert not one.is_broken(4.0, 4.5)
