from pathlib import Path

import pytest

from setcmas_ctrl.scripts.function import checked_function
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
