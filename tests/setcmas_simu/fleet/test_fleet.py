import numpy as np
import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import (
    format_per_robot,
    format_robots,
    is_per_robot,
    parse_per_robot,
    parse_robots,
    start_poses,
)


@pytest.mark.parametrize(
    ('text', 'values'),
    [
        ('1:a', {1: 'a'}),
        ('1:a,2-3:b', {1: 'a', 2: 'b', 3: 'b'}),
        ('1,3:a, 2:b', {1: 'a', 2: 'b', 3: 'a'}),
        ('1:a,b,2:c:d', {1: 'a,b', 2: 'c:d'}),
        (r'1:C:\law.py,2:/x/y,z.py', {1: r'C:\law.py', 2: '/x/y,z.py'}),
    ],
)
def test_values_of_robots(text, values):
    assert is_per_robot(text)
    assert parse_per_robot(text, '--algo') == values


@pytest.mark.parametrize('text', ['law.py', 'a,2:b.py', './1:law.py', r'C:\law.py', '1.py', '1-2'])
def test_other_texts_are_names(text):
    assert not is_per_robot(text)


@pytest.mark.parametrize('text', ['1:a,1:b', '1:', '0:a', '2-1:a', '1:a,2: '])
def test_malformed_texts_are_refused(text):
    with pytest.raises(SetcmasError):
        parse_per_robot(text, '--algo')


def test_values_are_written_as_they_are_read():
    values = {1: 'a', 2: 'b', 3: 'b', 5: 'a'}

    assert format_per_robot(values) == '1,5:a,2-3:b'
    assert parse_per_robot(format_per_robot(values), '--algo') == values


def test_one_robot_starts_at_the_origin():
    np.testing.assert_array_equal(start_poses(1), np.zeros((3, 1)))


def test_eight_robots_start_as_in_ros_1():
    x = [5, 5, -5, -5, 0, 5, 0, -5]
    y = [5, -5, -5, 5, 5, 0, -5, 0]

    np.testing.assert_array_equal(start_poses(8), [x, y, np.zeros(8)])
    np.testing.assert_array_equal(start_poses(3), start_poses(8)[:, :3])


@pytest.mark.parametrize('nb_robots', [9, 50, 300])
def test_further_robots_keep_a_metre_apart(nb_robots):
    x, y, _ = start_poses(nb_robots)
    distances = np.hypot(x[:, None] - x, y[:, None] - y)
    np.fill_diagonal(distances, np.inf)

    assert distances.min() >= 1.0


@pytest.mark.parametrize(
    ('text', 'robots'),
    [('1', [1]), ('1-4', [1, 2, 3, 4]), ('7, 2-3', [2, 3, 7]), ('3,3,1-2', [1, 2, 3])],
)
def test_parse_robots(text, robots):
    assert parse_robots(text) == robots


@pytest.mark.parametrize('text', ['', '0', '4-1', 'a', '1-', '1,,2', '-3', '1.5', '99999'])
def test_malformed_robots_are_refused(text):
    with pytest.raises(SetcmasError, match='invalid robots'):
        parse_robots(text)


@pytest.mark.parametrize('text', ['1', '1-4', '1,3-5,9'])
def test_format_robots_inverts_parse_robots(text):
    assert format_robots(parse_robots(text)) == text
