import numpy as np
import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_tools.records.fleet_table import COLUMNS, fleet_table, read_csv, write_csv

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
    write_csv(table, tmp_path / 'fleet.csv')

    again = read_csv(tmp_path / 'fleet.csv')

    np.testing.assert_allclose(again.t, table.t, atol=5.1e-7)
    np.testing.assert_array_equal(again.robot, table.robot)
    for name in COLUMNS[2:]:
        np.testing.assert_allclose(getattr(again, name), getattr(table, name), atol=5.1e-10)
    write_csv(again, tmp_path / 'again.csv')
    assert (tmp_path / 'again.csv').read_bytes() == (tmp_path / 'fleet.csv').read_bytes()


def test_format(tmp_path):
    write_csv(fleet_table([[-0.25, 3, 1, 2, 0.5, 0, -1]]), tmp_path / 'fleet.csv')

    assert (tmp_path / 'fleet.csv').read_bytes() == (
        f'{HEADER}\n-0.250000,3,1.000000000,2.000000000,0.500000000,0.000000000,-1.000000000\n'
    ).encode()


def test_lost_poses_are_kept_as_nan(tmp_path):
    (tmp_path / 'fleet.csv').write_text(f'{HEADER}\n0,1,nan,nan,nan,0,0\n1,1,1,1,1,0,0\n')

    assert np.isnan(read_csv(tmp_path / 'fleet.csv').x).tolist() == [True, False]


@pytest.mark.parametrize('lead', ['', '\ufeff'])
@pytest.mark.parametrize('ending', ['\n', '\r\n'])
def test_files_that_a_spreadsheet_has_saved(tmp_path, lead, ending):
    path = tmp_path / 'fleet.csv'
    path.write_bytes(f'{lead}{HEADER}{ending}0,1,1,2,3,4,5{ending}'.encode())

    assert read_csv(path).omega.tolist() == [5.0]


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
        read_csv(path)

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
        read_csv(path)
