import os
import subprocess
import sys
from pathlib import Path

from processes import run_setcmas

HERE = str(Path(__file__).parent)


COMMANDS = """
from launch_scripts.cli import VERBS, build_parser, main
for verb in VERBS:
    build_parser(verb)
for line in (
    'offline --algo consensus --nb-robots 2 --duration 1 --no-plots -o out',
    'metrics out',
    'csv_to_plot out',
    'new my_law',
    'list',
):
    assert main(line.split()) == 0, line
"""


def test_every_verb_can_be_loaded_and_a_run_offline_is_used(tmp_path):
    done = subprocess.run(
        [sys.executable, '-c', COMMANDS],
        env=os.environ | {'PYTHONPATH': HERE},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ''


def test_the_doctor_reports_its_findings(tmp_path):
    result = run_setcmas('doctor', cwd=tmp_path, PYTHONPATH=HERE)

    assert result.returncode in (0, 1)
    assert 'Traceback' not in result.stdout + result.stderr
    assert 'ROS 2 Jazzy is missing' in result.stdout
