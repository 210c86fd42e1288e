"""Resets: a robot is put somewhere else, and nothing of that is driven."""

import numpy as np
import pytest
from runs import measure

from setcmas_simu.errors import SetcmasError
from setcmas_tools.run.fleet_motion import (
    COLUMNS,
    Track,
    fleet_table,
    on_grid,
    read_fleet,
    resets,
    write_fleet,
)

HEADER = ','.join(COLUMNS)


def test_rows_are_sorted_by_time_then_robot():
    table = fleet_table([[1.0, 2, *range(5)], [0.5, 3, *range(5)], [1.0, 1, *range(5)]])

    assert table.t.tolist() == [0.5, 1.0, 1.0]
    assert table.robot.tolist() == [3, 1, 2]
    assert table.robots == [1, 2, 3]
    assert table.of(2).t.tolist() == [1.0]
    assert table.omega.tolist() == [4.0, 4.0, 4.0]


def test_written_and_read_again(tmp_path):
    chance = np.random.default_rng(1)
    rows = chance.normal(size=(100, 7))
    rows[:, 1] = chance.integers(1, 9, 100)
    table = fleet_table(rows)
    write_fleet(table, tmp_path / 'fleet.csv')

    again = read_fleet(tmp_path / 'fleet.csv')

    np.testing.assert_allclose(again.t, table.t, atol=5.1e-7)
    np.testing.assert_array_equal(again.robot, table.robot)
    for name in COLUMNS[2:]:
        np.testing.assert_allclose(getattr(again, name), getattr(table, name), atol=5.1e-10)
    write_fleet(again, tmp_path / 'again.csv')
    assert (tmp_path / 'again.csv').read_bytes() == (tmp_path / 'fleet.csv').read_bytes()


def test_format(tmp_path):
    write_fleet(fleet_table([[-0.25, 3, 1, 2, 0.5, 0, -1]]), tmp_path / 'fleet.csv')

    assert (tmp_path / 'fleet.csv').read_bytes() == (
        f'{HEADER}\n-0.250000,3,1.000000000,2.000000000,0.500000000,0.000000000,-1.000000000\n'
    ).encode()


def test_lost_poses_are_kept_as_nan(tmp_path):
    (tmp_path / 'fleet.csv').write_text(f'{HEADER}\n0,1,nan,nan,nan,0,0\n1,1,1,1,1,0,0\n')

    assert np.isnan(read_fleet(tmp_path / 'fleet.csv').x).tolist() == [True, False]


@pytest.mark.parametrize('lead', ['', '\ufeff'])
@pytest.mark.parametrize('ending', ['\n', '\r\n'])
def test_files_that_a_spreadsheet_has_saved(tmp_path, lead, ending):
    path = tmp_path / 'fleet.csv'
    path.write_bytes(f'{lead}{HEADER}{ending}0,1,1,2,3,4,5{ending}'.encode())

    assert read_fleet(path).omega.tolist() == [5.0]


@pytest.mark.parametrize(
    ('content', 'line', 'shown'),
    [
        ('', 1, "''"),
        ('a;b;c\n', 1, "'a;b;c'"),
        (f'{HEADER}\n0,1,1,1,1,1,1\n0,1,1,1\n', 3, "'0,1,1,1'"),
        (f'{HEADER}\n0,1,one,1,1,1,1\n', 2, "'0,1,one,1,1,1,1'"),
        (f'{HEADER}\n0,0,1,1,1,1,1\n', 2, 'robot a whole number from 1'),
        (f'{HEADER}\n0,1.5,1,1,1,1,1\n', 2, "'0,1.5"),
        (f'{HEADER}\nnan,1,1,1,1,1,1\n', 2, "'nan,1"),
        (f'{HEADER}\n0,1,1,1,1,1,1\n\n', 3, "''"),
    ],
)
def test_damaged_files_are_told_with_file_line_and_what_is_accepted(
    tmp_path, content, line, shown
):
    path = tmp_path / 'fleet.csv'
    path.write_text(content)

    with pytest.raises(SetcmasError) as error:
        read_fleet(path)

    assert f"'{path}', line {line}: " in str(error.value)
    assert shown in str(error.value)
    assert HEADER in str(error.value)
    assert '\n' not in str(error.value)


@pytest.mark.parametrize('content', [f'{HEADER}\n'.encode(), b'\xff\xfe\x00', None])
def test_other_files_that_are_no_tables(tmp_path, content):
    path = tmp_path / 'fleet.csv'
    if content:
        path.write_bytes(content)

    with pytest.raises(SetcmasError, match=r"fleet\.csv' (holds no rows|is not a CSV|cannot be)"):
        read_fleet(path)


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
    assert motion.path_length_m == pytest.approx(4.9)
    assert motion.mean_speed_m_s <= motion.largest_speed_m_s


@pytest.mark.parametrize('rate', [25.0, 10.0, 2.0])
def test_no_line_joins_what_is_before_a_reset_and_after(put_back, rate):
    steps = np.diff(on_grid(put_back, rate).x[0])

    assert np.nanmin(steps) > 0
    assert np.nanmax(steps) == pytest.approx(0.5 / rate)


def test_what_could_have_been_driven_is_no_reset():
    noise = 0.02 * np.random.default_rng(0).normal(size=len(T))
    assert not resets(driven(0.5 * T + noise)).any()
    assert not resets(driven(3 * T, v=3.0)).any()
    assert not resets(driven(50 * T, v=0.0)).any()  # its odometry tells no speed


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
