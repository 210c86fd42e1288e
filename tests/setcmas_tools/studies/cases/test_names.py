import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_tools.studies.cases.names import checked_name, value_of, with_values

SCRIPT = {'K', 'loss', 'PLACES'}


def test_options_and_names_of_the_script_are_told_apart():
    assert checked_name('K', SCRIPT) == 'K'
    assert checked_name('nb-robots', SCRIPT) == 'nb_robots'
    given = {'nb_robots': 3, 'loss': 0.1, 'set': {'D': 1}}
    values = {'nb_robots': 5, 'K': 2, 'set.loss': 7, 'option.loss': 0.3}

    assert with_values(given, values) == {
        'nb_robots': 5,
        'loss': 0.3,
        'set': {'D': 1, 'K': 2, 'loss': 7},
    }


@pytest.mark.parametrize(
    ('name', 'told'),
    [
        ('loss', "must be 'option.loss' or 'set.loss'"),
        ('delya', 'did you mean delay'),
        ('PLACE', 'did you mean PLACES'),
        ('output', 'there is no such name'),
        ('set.vnom', 'there is no such name'),
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
    for name, value in (('loss', '1.5'), ('nb_robots', 2.5), ('event_triggered', '3')):
        with pytest.raises(SetcmasError, match='must be'):
            value_of(name, value)
