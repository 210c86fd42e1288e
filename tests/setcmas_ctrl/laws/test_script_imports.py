import sys

import pytest
from control_functions import load_control

from setcmas_ctrl.laws.script_imports import helper_modules
from setcmas_simu.errors import SetcmasError

LAW = """
import numpy as np
import gains, plans.circle
from team import *
def control(i, n, poses, t):
    from tools import angles
    return 0, 0
"""


@pytest.fixture
def folder(tmp_path):
    """A function that writes files, and returns law.py; __ in names is a folder."""

    def write(**texts):
        for name, text in texts.items():
            path = tmp_path / (name.replace('__', '/', 1) + '.py')
            path.parent.mkdir(exist_ok=True)
            path.write_text(text)
        return tmp_path / 'law.py'

    return write


@pytest.fixture
def needed_files(folder, tmp_path):
    """A function that writes files, and returns the names of those that law.py needs."""

    def needed_files(law, **texts):
        found = helper_modules(folder(law=law, **texts))
        return [path.relative_to(tmp_path).as_posix() for path in found]

    return needed_files


def test_modules_and_packages_and_what_they_import(needed_files):
    texts = {
        'gains': 'import more',
        'more': 'import gains, law',
        'plans__circle': '',
        'plans__square': '',
        'team__init': '',
        'tools__angles': 'from . import turns\nfrom .turns import half',
        'tools__turns': 'half = 0.5',
        'unused': '',
    }

    assert needed_files(LAW, **texts) == [
        'gains.py',
        'more.py',
        'plans/circle.py',
        'tools/angles.py',
        'tools/turns.py',
    ]


def test_relative_imports_below_a_home_that_is_a_link(needed_files, tmp_path):
    needed_files(
        'import team.law', team__law='from . import gains\nfrom .. import no', team__gains=''
    )
    home = tmp_path.with_name('home')
    home.symlink_to(tmp_path)

    assert home / 'team/gains.py' in helper_modules(home / 'law.py')


def test_a_package_has_its_init(needed_files, tmp_path):
    (tmp_path.parent / 'elsewhere.py').touch()

    assert needed_files(LAW, team____init__='from .. import elsewhere') == ['team/__init__.py']


@pytest.mark.parametrize('text', ['def (', 'x = "\0"', '# -*- coding: none -*-\n'])
def test_a_module_that_is_no_python_is_there_all_the_same(needed_files, text):
    assert needed_files(LAW, gains=text) == ['gains.py']


COUNTER = 'calls = 0\ndef count():\n    global calls\n    calls += 1\n    return calls\n'


@pytest.mark.parametrize(
    ('statement', 'call'),
    [
        ('import lazy_counter', 'lazy_counter.count()'),
        ('from lazy_counter import count', 'count()'),
        ('import lazy_package.inner', 'lazy_package.inner.count()'),
        ('from lazy_package import inner', 'inner.count()'),
        ('import lazy_package.inner as inner', 'inner.count()'),
        ('from lazy_package.relative import count', 'count()'),
        ('import lazy_indirect', 'lazy_indirect.count()'),
    ],
)
@pytest.mark.parametrize('place', ['top', 'function'])
def test_helpers_are_fresh_for_every_robot_wherever_they_are_imported(
    folder, statement, call, place
):
    top, body = ('', statement) if place == 'function' else (statement, 'pass')
    path = folder(
        lazy_counter=COUNTER,
        lazy_package____init__='',
        lazy_package__inner=COUNTER,
        lazy_package__relative='from .inner import count\n',
        lazy_indirect='def count():\n    import lazy_counter\n    return lazy_counter.count()\n',
        law=f'{top}\ndef control(i, n, p, t):\n    {body}\n    return {call}, 0\n',
    )
    first, second = load_control(path, 1), load_control(path, 2)

    assert [first(1, 2, None, 0.0)[0] for _ in range(3)] == [1, 2, 3]
    assert second(2, 2, None, 0.0)[0] == 1
    helpers = {'lazy_counter', 'lazy_package', 'lazy_indirect'}
    assert helpers.isdisjoint(name.partition('.')[0] for name in sys.modules)
    assert not [finder for finder in sys.meta_path if 'ScriptImports' in repr(finder)]


def test_the_newest_helper_is_loaded_though_it_is_as_long_and_as_old(folder, tmp_path):
    law = 'import edited_helper\ndef control(i, n, p, t):\n    return edited_helper.V, 0\n'
    values = []
    for value in (1, 2):
        path = folder(edited_helper=f'V = {value}\n', law=law)
        values.append(load_control(path, 1)(1, 1, None, 0.0)[0])

    assert values == [1, 2]
    assert not (tmp_path / '__pycache__').exists()


def test_a_drawing_module_in_the_folder_of_the_script_is_not_that_of_ros_1(folder):
    path = folder(
        rviz_marker='import rospy\n',
        law='import rviz_marker\n'
        'def control(i, n, p, t):\n    rviz_marker.publish_marker(0, 0, 0, i)\n    return 1, 0\n',
    )

    assert load_control(path, 1)(1, 1, None, 0.0) == (1, 0)


def test_what_a_helper_cannot_import_is_reported_with_its_line(folder):
    law = 'import failing_helper\ndef control(i, n, p, t):\n    return 0, 0\n'
    path = folder(failing_helper='x = 1\nimport no_such_module\n', law=law)

    message = r'failing_helper\.py, line 2 \(imported by law\.py\): ModuleNotFound'
    with pytest.raises(SetcmasError, match=message):
        load_control(path, 1)


def test_a_folder_of_that_name_does_not_hide_an_installed_package(folder, tmp_path):
    (tmp_path / 'colorsys').mkdir()
    law = 'import colorsys\ndef control(i, n, p, t):\n    return colorsys.rgb_to_hls(0, 0, 0)\n'

    assert load_control(folder(law=law), 1)(1, 1, None, 0.0) == (0, 0, 0)
