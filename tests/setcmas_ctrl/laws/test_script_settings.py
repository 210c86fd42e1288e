import numpy as np
import pytest

from setcmas_ctrl.laws.script_loader import load_script
from setcmas_ctrl.laws.script_settings import parse_setting
from setcmas_simu.errors import SetcmasError

SCRIPT = """
from math import pi
import numpy as np
from names_to_set import *
from names_to_set import GAIN
W = 0.5
PERIOD = 2 * pi / W
WPL = [[0, 0]]
NB_WP = len(WPL)
POINTS = np.array([[1, 2]])
PLACE = (1, 2)
KP, KI = 1, 2
NAME: str = 'a'
LATER = None
if W > 1:
    FAST = True
    TWICE = 2 * FAST
else:
    FAST = False
def control(robotNo, nbRobots, poses, t):
    return 0, 0
"""


@pytest.fixture
def load(tmp_path):
    """A function that loads a script with settings for robot 1."""
    (tmp_path / 'names_to_set.py').write_text('STARRED = 1\nGAIN = 1\n')
    path = tmp_path / 'law.py'

    def load(*texts, script=SCRIPT):
        path.write_text(script)
        return load_script(path, 1, settings=dict(map(parse_setting, texts)))

    return load


@pytest.mark.parametrize(
    ('text', 'value'),
    [
        ('a=1', 1),
        ('a=1e-3', 0.001),
        ('a=-2E5', -2e5),
        ('a= .5', 0.5),
        ('a=[[1, 1e-1], [2, 2]]', [[1, 0.1], [2, 2]]),
        ('a={b: 1e3}', {'b': 1000.0}),
        ('a=text=text', 'text=text'),
        ('a=true', True),
    ],
)
def test_values_are_read_as_yaml_and_numbers_as_numbers(text, value):
    assert dict([parse_setting(text)]) == {'a': value}


@pytest.mark.parametrize('text', ['a', 'a=', '=1', '1a=2', 'a b=2', 'a=[1', 'a=*'])
def test_other_forms_are_refused_with_an_example(text):
    with pytest.raises(SetcmasError, match=r'must be NAME=VALUE, such as kp=1\.2') as caught:
        dict([parse_setting(text)])
    assert '\n' not in str(caught.value)


def test_names_are_set_however_they_are_given_their_value(load):
    module = load('KI=7', 'NAME=b', 'LATER=[1]', 'W=2', 'FAST=false')

    assert (module.KP, module.KI, module.NAME, module.LATER) == (1, 7, 'b', [1])
    assert (module.FAST, module.TWICE) == (False, 0)


@pytest.mark.parametrize(
    'statement',
    [
        'if True:\n    {}',
        'if False:\n    pass\nelse:\n    {}',
        'for _ in (1, 2):\n    {}',
        'with open(__file__):\n    {}',
        'try:\n    {}\nfinally:\n    pass',
        'try:\n    1 / 0\nexcept ZeroDivisionError:\n    {}',
        'match 1:\n    case 1:\n        {}',
    ],
)
def test_what_is_derived_inside_a_statement_follows(load, statement):
    law = statement.format('K = 1.0; W = 2 * K') + '\ndef control(i, n, p, t):\n    return K, W\n'
    module = load('K=5', script=law)

    assert (module.K, module.W) == (5, 10)


def test_every_assignment_of_the_top_level_is_replaced_and_none_in_a_function(load):
    script = (
        'K = 1\nK += 1\nBOTH = [K * i for i in (1, K)]\nfor N in (1, 2):\n    LAST = N\n'
        'def control(i, n, p, t):\n    global K\n    K = K + 1\n    return K, N\n'
    )
    module = load('K=5', 'N=7', script=script)

    assert (module.K, module.BOTH, module.LAST) == (5, [5, 25], 2)
    assert [module.control(1, 1, None, 0) for _ in range(2)] == [(6, 7), (7, 7)]


def test_a_value_gets_the_type_of_the_one_that_it_replaces(load):
    module = load('POINTS=[[0.5, 1], [2, 3]]', 'PLACE=[3, 4]')

    np.testing.assert_array_equal(module.POINTS, [[0.5, 1], [2, 3]])
    assert module.PLACE == (3, 4)


def test_robots_do_not_share_a_value(tmp_path):
    path = tmp_path / 'law.py'
    path.write_text('WPL = []\ndef control(i, n, p, t):\n    return 0, 0\n')
    settings = dict(map(parse_setting, ['WPL=[1]']))
    first, second = (load_script(path, robot, settings=settings) for robot in (1, 2))
    first.WPL.append(2)

    assert second.WPL == [1]


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('w=1', r"setting w: law\.py has no module-level name 'w'; it has .*; did you mean W\?"),
        ('robotNo=1', 'has no module-level name'),
        ('np=1', r'law\.py imports it; choose a name that law\.py assigns itself: FAST, '),
        ('pi=3', 'imports it'),
        ('GAIN=3', 'imports it'),
        ('STARRED=3', 'has no module-level name'),
        ('TWICE=1', 'has no module-level name'),  # it is assigned only if W > 1
        ('control=1', 'it is a function'),
        ('W=fast', "'fast' is a string; it must be a number, since law.py has W = 0.5"),
        ('W=[1]', 'is a list'),
        ('W=true', 'is true or false'),
        ('WPL=3', 'it must be a list'),
        ('POINTS=3', 'it must be a list'),
        ('PERIOD=x', 'it must be a number'),
    ],
)
def test_names_that_are_no_plain_values_of_the_script_are_refused(load, text, message):
    with pytest.raises(SetcmasError, match=message) as caught:
        load(text)
    assert '\n' not in str(caught.value)


def test_literals_are_compared_before_the_script_runs(load):
    with pytest.raises(SetcmasError, match='it must be a number'):
        load('K=fast', script='K = 0.5\nraise SystemExit\ndef control(i, n, p, t): pass\n')
