import os
import subprocess
import sys
from pathlib import Path

from processes import run_setcmas

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


def test_every_verb_can_be_loaded():
    code = 'from launch_scripts.cli import VERBS, build_parser\nfor v in VERBS: build_parser(v)'
    environment = os.environ | {'PYTHONPATH': HERE}
    subprocess.run([sys.executable, '-c', code], env=environment, check=True)


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


def test_the_doctor_reports_its_findings(tmp_path):
    result = run_setcmas('doctor', cwd=tmp_path, PYTHONPATH=HERE)

    assert result.returncode in (0, 1)
    assert 'Traceback' not in result.stdout + result.stderr
    assert 'this machine has no network' in result.stdout
