import signal
import sys
import time

import pytest
from processes import SETCMAS, run_here

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

    third = ('--graph', 'path', '--vnom', '0.2', '-o', 'run', '--no-plots')
    again = run_here('offline', '--from', 'study', *third, cwd=tmp_path)
    assert again.returncode == 0, again.stderr
    assert f', {study.table["disagreement"][2]:.3f} m at the end' in again.stdout
    assert 'not compared' not in again.stdout


@pytest.mark.skipif(sys.platform == 'win32', reason='signals')
def test_ctrl_c_ends_a_study_that_hangs(tmp_path, start):
    (tmp_path / 'law.py').write_text(HANGING)
    command = [*SETCMAS, *SWEEP, '--algo', 'law.py', '--seeds', '5', '--jobs', '1']
    process = start(*command, cwd=tmp_path)
    while not (tmp_path / 'study' / 'run.yaml').exists():
        assert process.popen.poll() is None, process.output()
        time.sleep(0.02)
    assert process.end(signal.SIGINT) == 130
    assert 'stopped; there are no runs that had finished' in process.output()
    assert 'Traceback' not in process.output()
