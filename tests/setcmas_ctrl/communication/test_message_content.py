from collections import UserDict

import numpy as np
import pytest

from setcmas_ctrl.communication.message_content import (
    MOST_NAMES,
    MOST_NUMBERS,
    Content,
    checked_value,
    decoded,
    encoded,
    plain,
    read_only,
)

VALUES = [
    3,
    -1.5,
    True,
    np.float32(0.5),
    [1, 2, 3],
    [7],
    [[7]],
    ((1, 2), (3, 4), (5, 6)),
    np.eye(8),
    {'x': 1.5, 'goal': [2, 3], 'P': np.eye(2), 'one': [4]},
    UserDict(x_1=1),
]


@pytest.mark.parametrize('given', VALUES, ids=repr)
def test_a_value_is_the_same_after_its_way_over_a_topic(given):
    value = checked_value(given)
    content = decoded(encoded(Content(0.3, value)))

    assert content.t == 0.3
    assert plain(content.value) == plain(value)
    for one, expected in zip(*map(parts, (content.value, given)), strict=True):
        np.testing.assert_array_equal(one, expected)


def parts(value):
    return list(value.values()) if hasattr(value, 'values') else [value]


def test_messages_are_json_that_people_can_read():
    value = checked_value({'x': 1.5, 'goal': [2, 3], 'A': np.eye(2)})

    assert encoded(Content(4.2, value)) == (
        '{"t": 4.2, "value": {"x": 1.5, "goal": [2.0, 3.0], "A": [[1.0, 0.0], [0.0, 1.0]]}}'
    )


@pytest.mark.parametrize(
    ('given', 'message'),
    [
        ('a text', "got 'a text'; it must be a finite number, an array of numbers"),
        (None, 'got None; it must be'),
        (1 + 2j, 'it must be a finite number'),
        (2**70, 'it must be a finite number'),
        ([[1, 2], [3]], 'it must be a finite number'),
        ({'x': {'y': 1}}, 'a flat dict of names'),
        (np.zeros((2, 2, 2)), 'up to 2 dimensions'),
        ({1: 2.0}, "got the name 1 in a dict; it must be a string such as 'x_1'"),
        ({'a b': 2.0}, "got the name 'a b'"),
        ({'x' * 41: 2.0}, 'at most 40 letters'),
        (np.nan, 'got nan, which is not finite'),
        ([1.0, np.inf], 'which is not finite'),
        (np.ma.array([1.0, 2.0], mask=[0, 1]), 'which is not finite'),
        ([], 'got 0 numbers; it must get 1 to 64 at a time'),
        (np.zeros(MOST_NUMBERS + 1), 'got 65 numbers'),
        ({'a': np.zeros(60), 'b': np.zeros(5)}, 'got 65 numbers'),
        ({}, 'a dict with 0 names'),
        ({f'x{i}': 0 for i in range(MOST_NAMES + 1)}, '17 names; it must have 1 to 16'),
    ],
    ids=repr,
)
def test_what_cannot_be_sent_is_described(given, message):
    with pytest.raises((TypeError, ValueError)) as error:
        checked_value(given)

    assert str(error.value).startswith('network.send got ')
    assert message in str(error.value)


def test_a_value_is_a_copy_that_cannot_be_changed():
    array = np.zeros(3)
    value = read_only(checked_value({'v': array}))
    array[0] = 1.0

    assert value['v'][0] == 0.0
    with pytest.raises(ValueError, match='read-only'):
        value['v'][0] = 1.0
    with pytest.raises(ValueError, match='WRITEABLE'):
        value['v'].flags.writeable = True
    with pytest.raises(TypeError):
        value['v'] = 1.0


@pytest.mark.parametrize(
    'text',
    [
        '', 'hello', '[1, 2]', '5', '{"t": 1.0}', '{"value": 1.0}', '{"t": [1.0], "value": 1.0}',
        '{"t": NaN, "value": 1.0}', '{"t": 1.0, "value": null}', '{"t": 1.0, "value": {"x y": 1}}',
        '{"t": 1.0, "value": ' + '[' * 100_000, '{"t": 1' + '0' * 400 + ', "value": 1}',
    ],
)  # fmt: skip
def test_messages_of_other_programs_may_be_invalid(text):
    with pytest.raises((TypeError, ValueError)):
        decoded(text)
