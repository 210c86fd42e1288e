"""A missing package of an extra: one line, exit status 2, and the command that installs it."""

import importlib
import sys

import pytest

from launch_scripts.cli import main
from setcmas_simu.errors import SetcmasError, needs

LAW = ('--algo', 'consensus', '--nb-robots', '2', '--duration', '1', '-o', 'out')


def test_other_errors_of_an_import_stay():
    with pytest.raises(AttributeError), needs('study'):
        raise AttributeError
    with pytest.raises(SetcmasError, match=r"pip install 'setcmas\[study\]'"), needs('study'):
        importlib.import_module('no_such_package')


@pytest.mark.parametrize(
    ('package', 'extra', 'command'),
    [
        ('daqp', 'filter', ('offline', *LAW, '--filter', 'barrier')),
        ('joblib', 'study', ('sweep', *LAW, '--seeds', '2')),
        ('cloudpickle', 'study', ('sweep', *LAW, '--seeds', '2')),
        ('distributed', 'cluster', ('sweep', *LAW, '--cluster', 'tcp://127.0.0.1:1')),
        ('jinja2', 'grade', ('grade', 'class', '--rubric', 'rubric.yaml', '-o', 'grades')),
        ('landlockpy', 'grade', ('grade', 'class', '--rubric', 'rubric.yaml', '-o', 'grades')),
    ],
)
def test_a_command_names_the_extra_that_it_lacks(
    tmp_path, monkeypatch, capsys, package, extra, command
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, package, None)
    (tmp_path / 'class').mkdir()
    (tmp_path / 'class' / 'law.py').touch()
    (tmp_path / 'rubric.yaml').write_text(RUBRIC)

    assert main([*command]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert package in line
    assert f"pip install 'setcmas[{extra}]'" in line


RUBRIC = """\
title: Meet
scenarios:
  - name: Two robots
    nb_robots: 2
    duration: 5
    criteria:
      - {name: they meet, metric: disagreement, at_most: 1, points: 1}
"""
