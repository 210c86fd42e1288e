from pathlib import Path

import numpy as np
import pytest

from setcmas_ctrl.control_law import ControlLaw
from setcmas_ctrl.laws.script_errors import ControlError
from setcmas_ctrl.laws.script_function import WrongResultError, checked_function, numbers_of
from setcmas_ctrl.si_to_uni_script import load_conversion
from setcmas_simu.errors import SetcmasError


@pytest.mark.parametrize(
    'arguments', ['nbRobots, robotNo, poses, t', 'poses, i, n, t', 'i, n, t, p', 'i, n, t, poses']
)
def test_arguments_in_another_order_are_refused(arguments):
    control = eval(f'lambda {arguments}: (0, 0)')

    with pytest.raises(SetcmasError, match='in another order; it must be control'):
        checked_function(control, Path('law.py'))


@pytest.mark.parametrize('arguments', ['i, n, p, time', 'robotNo, nbRobots, poses, t, k=1', '*a'])
def test_arguments_may_have_other_names(arguments):
    control = eval(f'lambda {arguments}: (0, 0)')

    assert checked_function(control, Path('law.py')) is control


@pytest.mark.parametrize(
    'result',
    [
        (1, 2),
        [1.0, 2.0],
        np.array([1, 2]),
        np.array([[1.0], [2.0]]),
        (np.float64(1), np.int32(2)),
        (np.array([1.0]), np.array([2.0])),
        (np.float32(1), 2),
        np.ma.array([1, 2]),
    ],
)
def test_two_numbers_in_any_form_will_do(result):
    assert numbers_of(result, (2,), 'control').tolist() == [1.0, 2.0]


@pytest.mark.parametrize(
    ('result', 'message'),
    [
        (5, 'returned 1 value: 5'),
        ((float('nan'), 0.0), 'not finite'),
        ((0, float('inf')), 'not finite'),
        ((np.float64('nan'), np.float32(0)), r'not finite: \(nan, 0.0\)'),
        (np.ma.array([1.0, 2.0], mask=[0, 1]), 'not finite: masked_array'),
        ((np.ma.array([1.0], mask=True), np.ma.array([2.0])), 'not finite'),
        ((np.ma.masked, 2.0), 'not finite'),
        (None, 'returned None$'),
        ('ab', "returned text: 'ab'"),
        (['1', '2'], r"returned text: \['1', '2'\]"),
        ((1j, 0), 'returned complex numbers'),
        ((None, 1), 'returned None in place of a number'),
        ({}, 'returned a dict'),
        ((1, [2, 3]), 'unequal kinds or lengths'),
        ([[1, 2], [3, 4]], 'returned 4 values in 2 x 2'),
    ],
)
def test_anything_else_is_refused_with_what_it_was(result, message):
    with pytest.raises(WrongResultError, match=message):
        numbers_of(result, (2,), 'control')


LAW = """def control(robotNo, nbRobots, poses, t):
    \'\'\'Return a velocity.\'\'\'
    def inner():
        return 9
    if t == 1:
        return (t,
                2, 3)
    for robot in range(2):
        if t == 2 and inner(): return 'a', 'b'
    if t == 3:
        return
    v = 0, inner()
"""


@pytest.mark.parametrize(
    ('t', 'message'),
    [
        (1.0, 'law.py, line 6: control returned 3 values: (1.0, 2, 3); it must return two finite'),
        (2.0, "law.py, line 9: control returned text: ('a', 'b')"),
        (3.0, 'law.py, line 11: control returned None; it must'),
        (4.0, 'law.py, line 1: control returned None: it reached its end without a return; it'),
    ],
)
def test_the_return_of_a_wrong_result_is_shown(tmp_path, t, message):
    path = tmp_path / 'law.py'
    path.write_text(LAW)
    law = ControlLaw(path, 1, 1)

    with pytest.raises(ControlError) as error:
        law(np.zeros((3, 1)), t)

    assert str(error.value).startswith(message)
    assert error.value.place[1] == int(message.split()[2].strip(':'))


def test_a_function_that_a_decorator_changes_is_shown_where_it_begins(tmp_path):
    path = tmp_path / 'own.py'
    path.write_text(
        'import functools\n@functools.cache\n'
        'def si_to_uni(velocity, pose, komega):\n    return 1, 2, 3\n'
    )

    with pytest.raises(ControlError, match=r'own\.py: si_to_uni returned 3 values'):
        load_conversion(path, 1)((0.0, 0.0), (0.0, 0.0, 0.0), 1.5)
