import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_tools.run.scenario import Scenario
from setcmas_tools.study.study_plan import (
    checked_name,
    parse_values,
    value_of,
    values_by_label,
    with_values,
)

SCRIPT = {'K', 'loss', 'PLACES'}


def test_options_and_names_of_the_script_are_distinguished():
    assert checked_name('K', SCRIPT) == 'K'
    assert checked_name('nb-robots', SCRIPT) == 'nb_robots'
    given = Scenario.of('consensus', nb_robots=3, loss=0.1, set={'D': 1})

    assert with_values(given, {'nb_robots': 5, 'K': 2, 'loss': 0.3}).changed() == {
        'algo': 'consensus',
        'nb_robots': 5,
        'loss': 0.3,
        'set': {'D': 1, 'K': 2},
    }


@pytest.mark.parametrize(
    ('name', 'told'),
    [
        ('loss', 'both an option and a variable of the script'),
        ('delya', 'did you mean delay'),
        ('PLACE', 'did you mean PLACES'),
        ('output', 'unknown name'),
        ('seed', 'unknown name'),
    ],
)
def test_a_name_that_is_unknown_or_two_things(name, told):
    with pytest.raises(SetcmasError, match=told):
        checked_name(name, SCRIPT)


def test_values_are_those_that_the_option_or_the_script_takes():
    assert value_of('loss', '0.2') == 0.2
    assert value_of('nb_robots', 8.0) == 8
    assert isinstance(value_of('nb_robots', 8.0), int)
    assert value_of('event_triggered', 'yes') is True
    assert value_of('graph', 'ring') == 'ring'
    assert value_of('K', '1e-3') == 0.001
    assert value_of('PLACES', '[[1, 2]]') == [[1, 2]]


@pytest.mark.parametrize(
    ('text', 'values'),
    [
        ('0.2:2:10', [0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0]),
        ('-1:1:3', [-1.0, 0.0, 1.0]),
        ('log:0.1:10:3', [0.1, 1.0, 10.0]),
        ('0,0.2, 0.4', ['0', '0.2', '0.4']),
        ('ring,path', ['ring', 'path']),
        ('{a: 1}', ['{a: 1}']),  # a list with one word
        ('[[1, 2], [3, 4]]', [[1, 2], [3, 4]]),
        ("['1:a.py,2:b.py', c]", ['1:a.py,2:b.py', 'c']),
    ],
)
def test_lists_and_ranges(text, values):
    assert parse_values('K', text) == values


@pytest.mark.parametrize(
    'text', ['', '0,,1', '0:1:0', '0.2:2', 'log:1:2', '0:1:2.5', 'log:0:1:3', '[1']
)
def test_an_invalid_variation_is_reported_in_one_line(text):
    with pytest.raises(SetcmasError, match=r"--vary K '.*' must ") as told:
        parse_values('K', text)
    assert '\n' not in str(told.value)


def test_values_that_the_table_could_not_tell_apart_are_refused():
    values = [lambda *_: True, lambda *_: False]

    with pytest.raises(SetcmasError, match=r'--vary ctc: 2 values, some of one name: <lambda>, '):
        values_by_label('ctc', values)
    assert [*values_by_label('ctc', dict(zip('ab', values, strict=True)))] == ['a', 'b']
