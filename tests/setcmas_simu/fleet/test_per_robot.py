import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.per_robot import format_per_robot, is_per_robot, parse_per_robot


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
