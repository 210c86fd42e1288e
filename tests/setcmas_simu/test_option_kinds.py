import math
from pathlib import Path

import numpy as np
import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_simu.option_groups import plain
from setcmas_simu.option_kinds import NB_ROBOTS, RATE, Kind, Number, OneOf, PathTo, Robots, Whole
from setcmas_simu.yaml_entries import entries_of, yaml_line

SPEED = Number(above=0, unit='m/s')
PROBABILITY = Number(least=0, most=1)


@pytest.mark.parametrize(
    ('kind', 'text', 'value'),
    [
        (SPEED, '0.1', 0.1),
        (SPEED, 'inf', math.inf),
        (PROBABILITY, '0', 0.0),
        (PROBABILITY, '1', 1.0),
        (RATE, '200', 200.0),
        (NB_ROBOTS, '8', 8),
        (OneOf(('ring', 'path')), 'path', 'path'),
        (PathTo(), 'out/a b', Path('out/a b')),
        (Robots(), '1-3,5', (1, 2, 3, 5)),
        (Kind(), '', ''),
        (Kind(), "a\x85\u2028: 'b' \udce9\n#", "a\x85\u2028: 'b' \udce9\n#"),
    ],
)
def test_a_value_comes_from_a_text_and_from_a_document(kind, text, value):
    assert kind.value(text) == value
    kind.check('it', value)
    assert (
        kind.value(entries_of(yaml_line({'it': plain(value)}), Path('f')).value['it'].plain())
        == value
    )


def test_numbers_keep_their_last_bit():
    line = yaml_line({'v': 0.1 + 0.2})
    assert SPEED.of(entries_of(line, Path('f')).value['v']) == 0.1 + 0.2


@pytest.mark.parametrize(
    ('kind', 'value', 'message'),
    [
        (SPEED, math.nan, 'it is nan; it must be above 0 m/s'),
        (SPEED, -1, 'it is -1; it must be above 0 m/s'),
        (SPEED, np.float64(0), 'it is 0; it must be above 0 m/s'),
        (SPEED, True, 'it is True; it must be a number above 0 m/s'),
        (SPEED, None, 'it is None; it must be a number above 0 m/s'),
        (Number(least=0), 'x', "it is 'x'; it must be a number of at least 0"),
        (SPEED, 'x', "it is 'x'; it must be a number above 0 m/s"),
        (Number(least=0, unit='s', finite=True), math.inf, 'must be at least 0 s and finite'),
        (PROBABILITY, 1.5, 'it is 1.5; it must be from 0 to 1'),
        (RATE, 1e6, 'it is 1000000; it must be above 0 and at most 200 Hz'),
        (NB_ROBOTS, 0, 'it is 0; it must be a whole number from 1'),
        (NB_ROBOTS, 2.0, 'it is 2; it must be a whole number from 1'),
        (Whole(0, 9), 10, 'it is 10; it must be a whole number from 0 to 9'),
        (Whole(0, 9), '1.5', "it is '1.5'; it must be a whole number from 0 to 9"),
        (OneOf(('a', 'b', 'c')), 'd', "it is 'd'; it must be a, b or c"),
        (OneOf(('a',)), ['a'], r"it is \['a'\]; it must be a"),
        (Robots(), '3-1', "it is '3-1'; it must be numbers from 1 and ranges"),
    ],
)
def test_a_refused_value_is_reported_with_what_it_must_be(kind, value, message):
    with pytest.raises(SetcmasError, match=message):
        kind.check('it', value)
