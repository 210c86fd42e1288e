import numpy as np

from setcmas_tools.records.fleet_grid import on_grid
from setcmas_tools.records.fleet_table import fleet_table


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


def test_a_single_row():
    grid = on_grid(table(([0.123], [1.0], [0.0])))

    assert grid.t.tolist() == [0.123]
    assert grid.x.tolist() == [[1.0]]
