import os
import socket
import subprocess
import sys
import time

import pytest
from processes import TIMEOUT_S, Process

from setcmas_simu.errors import SetcmasError
from setcmas_tools import sweep
from setcmas_tools.study.study_table import ROWS

LAW = 'from helper import K\n\ndef control(robotNo, nbRobots, poses, t):\n    return K, 0.0\n'


@pytest.fixture(autouse=True)
def _needs_distributed():
    pytest.importorskip('distributed')  # takes long: only where the tests run


def test_a_cluster_that_does_not_answer_is_reported(tmp_path):
    with pytest.raises(SetcmasError, match="cluster 'nowhere' does not answer"):
        sweep('consensus', 2, 1, cluster='nowhere', output=tmp_path / 'study')


@pytest.mark.nightly
def test_a_cluster_makes_the_same_table_though_a_worker_is_killed(tmp_path):
    (tmp_path / 'law.py').write_text(LAW)
    (tmp_path / 'helper.py').write_text('K = 0.1\n')
    given = {'vary': {'loss': '0:0.5:3'}, 'seeds': 40, 'random_poses': 'auto'}
    here = sweep(tmp_path / 'law.py', 5, 60, output=tmp_path / 'here', **given)
    with socket.socket() as free:
        free.bind(('127.0.0.1', 0))
        address = f'tcp://127.0.0.1:{free.getsockname()[1]}'
    away = tmp_path / 'away'
    away.mkdir()  # nothing of the law is there
    command = [sys.executable, '-m', 'distributed.cli.dask_scheduler']
    line = [*command, '--host', address, '--no-dashboard']
    scheduler = Process(line, tmp_path / 'scheduler', away, os.environ)
    command = [sys.executable, '-m', 'distributed.cli.dask_worker', address, '--nthreads', '1']
    workers = [
        Process(
            [*command, '--no-dashboard', '--no-nanny'], tmp_path / f'worker_{k}', away, os.environ
        )
        for k in range(2)
    ]
    try:
        for worker in workers:
            worker.wait_for_output('Registered to')
        script = f"""
from setcmas_tools import sweep
sweep({str(tmp_path / 'law.py')!r}, 5, 60, output='there', cluster={address!r}, **{given!r})
"""
        (tmp_path / 'study.py').write_text(script)
        study = subprocess.Popen([sys.executable, 'study.py'], cwd=tmp_path)
        part, deadline = tmp_path / 'there' / ROWS, time.monotonic() + TIMEOUT_S
        while not part.exists() or part.read_bytes().count(b'\n') < 40:
            assert study.poll() is None
            assert time.monotonic() < deadline
            time.sleep(0.02)
        workers[0].kill_group()
        assert study.wait(TIMEOUT_S) == 0
    finally:
        for process in (*workers, scheduler):
            process.kill_group()

    assert (tmp_path / 'there/runs.csv').read_bytes() == (here.folder / 'runs.csv').read_bytes()
