import pytest

from setcmas_ctrl.scripts.helper_modules import helper_modules

LAW = """
import numpy as np
import gains, plans.circle
from team import *
def control(i, n, poses, t):
    from tools import angles
    return 0, 0
"""


@pytest.fixture
def beside(tmp_path):
    """A function that writes files, and returns the names of those that law.py needs."""

    def beside(law, **texts):
        for name, text in {'law': law, **texts}.items():
            path = tmp_path / (name.replace('__', '/') + '.py')
            path.parent.mkdir(exist_ok=True)
            path.write_text(text)
        found = helper_modules(tmp_path / 'law.py')
        return [path.relative_to(tmp_path).as_posix() for path in found]

    return beside


def test_modules_and_packages_and_what_they_import(beside):
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

    assert beside(LAW, **texts) == [
        'gains.py',
        'more.py',
        'plans/circle.py',
        'tools/angles.py',
        'tools/turns.py',
    ]


def test_a_package_has_its_init(beside, tmp_path):
    (tmp_path / 'team').mkdir()
    (tmp_path / 'team' / '__init__.py').write_text('from .. import elsewhere')
    (tmp_path.parent / 'elsewhere.py').touch()

    assert beside(LAW) == ['team/__init__.py']


@pytest.mark.parametrize('text', ['def (', 'x = "\0"', '# -*- coding: none -*-\n'])
def test_a_module_that_is_no_python_is_there_all_the_same(beside, text):
    assert beside(LAW, gains=text) == ['gains.py']


def test_a_script_by_itself(beside):
    assert beside('import numpy\nfrom setcmas_ctrl import network\n') == []
