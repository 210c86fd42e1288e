"""Errors cross processes; a missing package of an extra gives one line and exit status 2."""

import importlib
import pickle
import sys
from importlib import metadata
from pathlib import Path

import pytest

from launch_scripts.cli import main
from setcmas_ctrl.laws.script_errors import ControlError
from setcmas_simu.errors import SetcmasError, install_command, needs
from setcmas_simu.option_groups import ClashError
from setcmas_simu.plugins import PluginError

LAW = ('--algo', 'consensus', '--nb-robots', '2', '--duration', '1', '-o', 'out')


def test_other_errors_of_an_import_stay(monkeypatch):
    with pytest.raises(AttributeError), needs('study'):
        raise AttributeError
    for system, text in (('linux', 'this installs it'), ('emscripten', 'which web pages do not')):
        monkeypatch.setattr('sys.platform', system)
        wanted = rf"no_such_package.*{text}.*pip install 'setcmas\[study\]'"
        with pytest.raises(SetcmasError, match=wanted), needs('study'):
            importlib.import_module('no_such_package')


@pytest.mark.parametrize(
    ('package', 'extra', 'command'),
    [
        ('daqp', 'filter', ('offline', *LAW, '--filter', 'barrier')),
        ('joblib', 'study', ('sweep', *LAW, '--seeds', '2')),
        ('pandas', 'study', ('sweep', *LAW, '--seeds', '2')),
        ('jinja2', 'grade', ('grade', 'class', '--rubric', 'rubric.yaml', '-o', 'grades')),
    ],
)
def test_a_command_names_the_extra_that_it_lacks(
    tmp_path, monkeypatch, capsys, package, extra, command
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, package, None)
    monkeypatch.delitem(sys.modules, 'setcmas_tools.study.study', raising=False)
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


WITH_MORE = [
    ClashError('{} needs {{it}} and {}', 'nb_robots', 'ctc'),
    ControlError('law.py, line 3: it fails', ('KeyError', Path('law.py'), 3), 'stops'),
    PluginError('law', "'circle' of package p 1", 'it is a class'),
]


@pytest.mark.parametrize('error', WITH_MORE, ids=lambda error: type(error).__name__)
def test_errors_with_more_than_a_message_cross_processes(error):
    other = pickle.loads(pickle.dumps(error))

    assert (str(other), vars(other)) == (str(error), vars(error))


def test_in_a_workspace_nobody_is_sent_to_pip(monkeypatch):
    def missing(name):
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(metadata, 'distribution', missing)

    assert install_command('study').startswith('PIP_BREAK_SYSTEM_PACKAGES=1 rosdep install')
