import signal
import sys
import time

import pytest
from processes import SETCMAS, refuses, run_here

from launch_scripts.cli import main
from setcmas_tools import Study

SWEEP = ('sweep', '--algo', 'consensus', '--nb-robots', '3', '--duration', '4', '-o', 'study')
HANGING = 'def control(robotNo, nbRobots, poses, t):\n    while True:\n        pass\n'


@pytest.mark.nightly
def test_a_study_and_one_of_its_runs(tmp_path):
    varied = ('--vary', 'graph=ring,path', '--vary', 'vnom=0.2:0.4:2', '--random-poses')
    done = run_here(*SWEEP, *varied, cwd=tmp_path)

    assert done.returncode == 0, done.stderr
    assert '4 runs: study/runs.csv   4 plots: study/plots' in done.stdout
    study = Study.load(tmp_path / 'study')
    assert study.table['vnom'].tolist() == [0.2, 0.4, 0.2, 0.4]

    again = run_here('offline', '--from', 'study/3', '-o', 'run', '--no-plots', cwd=tmp_path)
    assert again.returncode == 0, again.stderr
    assert f', {study.table["disagreement"][2]:.3f} m at the end' in again.stdout


def test_a_dry_run_prints_the_number_of_runs_and_runs_none(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)

    assert main([*SWEEP, '--seeds', '2000', '--dry-run']) == 0
    assert capsys.readouterr().out == '2,000 runs\n'
    assert not list(tmp_path.iterdir())


def test_a_name_that_is_varied_twice_is_refused(tmp_path):
    varied = ('--vary', 'K=1,2', '--vary', 'K=3')
    refuses(*SWEEP, *varied, message="'K' is varied twice", cwd=tmp_path)
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(sys.platform == 'win32', reason='signals')
def test_ctrl_c_ends_a_study_that_hangs(tmp_path, start):
    (tmp_path / 'law.py').write_text(HANGING)
    command = [*SETCMAS, *SWEEP, '--algo', 'law.py', '--seeds', '5', '--jobs', '1']
    process = start(*command, cwd=tmp_path)
    while not (tmp_path / 'study' / 'study.yaml').exists():
        assert process.popen.poll() is None, process.output()
        time.sleep(0.02)
    assert process.end(signal.SIGINT) == 130
    assert "stopped; run the same command with -o 'study' to continue" in process.output()
    assert 'Traceback' not in process.output()
