import os
import subprocess
import sys
from pathlib import Path

import pytest
from processes import run_setcmas

from launch_scripts.cli import VERBS

HERE = str(Path(__file__).parent)


def test_the_modules_are_blocked():
    result = subprocess.run(
        [sys.executable, '-c', 'import fcntl'],
        env=os.environ | {'PYTHONPATH': HERE},
        capture_output=True,
        text=True,
        check=False,
    )
    assert "No module named 'fcntl'" in result.stderr


@pytest.mark.parametrize('verb', VERBS)
def test_a_verb_shows_its_help(verb):
    result = run_setcmas(verb, '--help', PYTHONPATH=HERE)

    assert result.returncode == 0, result.stderr
    assert result.stderr == ''


def test_a_run_offline_and_what_is_done_with_it(tmp_path):
    for arguments in (
        ('offline', '--algo', 'consensus', '--nb-robots', '2', '--duration', '1', '-o', 'out'),
        ('metrics', 'out'),
        ('csv_to_plot', 'out'),
        ('new', 'my_law'),
        ('list',),
    ):
        result = run_setcmas(*arguments, cwd=tmp_path, PYTHONPATH=HERE)
        assert result.returncode == 0, result.stderr
        assert result.stderr == ''


def test_the_doctor_tells_what_it_finds(tmp_path):
    result = run_setcmas('doctor', cwd=tmp_path, PYTHONPATH=HERE)

    assert result.returncode in (0, 1)
    assert 'Traceback' not in result.stdout + result.stderr
    assert 'this machine has no network' in result.stdout
