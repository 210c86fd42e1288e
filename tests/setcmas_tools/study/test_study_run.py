"""Runs whose scripts fail, hang, die or change the process, and the workers of a cluster."""

import csv
import subprocess
import sys

import pytest

from setcmas_tools import sweep

SCRIPT = """
import math, os
import numpy
DOES = 'nothing'
ACTS = {
    'raises': 'raise ValueError("oh no")',
    'hangs': 'while True: pass',
    'exits': 'os._exit(3)',
    'patches': 'math.atan2 = numpy.array = None',
}
def control(robotNo, nbRobots, poses, t):
    if robotNo == 2 and 1 < t < 1.3:
        exec(ACTS.get(DOES, ''))
    return 0.1, 0.0
"""
EXPECTED = {
    'nothing': ('complete', '', ''),
    'raises': ('failed', '2', 'ValueError: oh no'),
    'hangs': ('died', '2', 'tb3_2: ended after 15 s (--timeout) at law.py, line 13'),
    'exits': ('died', '2', 'exit status 3'),
    'patches': ('complete', '', "'NoneType' object is not callable"),
    'ends': ('complete', '', ''),
}


STUDY = f"""
from setcmas_tools import sweep
if __name__ == '__main__':
    sweep(
        'law.py', 2, 3, vary={{'DOES': {list(EXPECTED)}}}, jobs=2, timeout=15, seeds=1,
        output='study',
    )
"""


@pytest.mark.nightly
def test_a_script_harms_its_own_run_alone(tmp_path):
    # In an interpreter of its own: one that has run scripts before forks its processes from one
    # that has not loaded what runs of a study share, so a script could break the loading.
    (tmp_path / 'law.py').write_text(SCRIPT)
    (tmp_path / 'study.py').write_text(STUDY)
    subprocess.run([sys.executable, 'study.py'], cwd=tmp_path, check=True)
    rows = list(csv.DictReader((tmp_path / 'study/runs.csv').read_text().splitlines()))

    assert [row['DOES'] for row in rows] == list(EXPECTED)
    assert rows[0]['disagreement'] == rows[-1]['disagreement'] > '0'
    for row in rows:
        state, robots, message = EXPECTED[row['DOES']]
        assert (row['state'], row['robots']) == (state, robots), (row['DOES'], row['message'])
        assert message in row['message']


LAW = 'from helper import K\n\ndef control(robotNo, nbRobots, poses, t):\n    return K, 0.0\n'


@pytest.mark.nightly
def test_the_workers_of_a_cluster_make_the_same_table(tmp_path):
    (tmp_path / 'law.py').write_text(LAW)
    (tmp_path / 'helper.py').write_text('K = 0.1\n')
    given = {'vary': {'loss': '0:0.5:3'}, 'seeds': 4, 'random_poses': 'auto'}
    here = sweep(tmp_path / 'law.py', 5, 10, output=tmp_path / 'here', **given)
    (tmp_path / 'study.py').write_text(f"""
import sys
import joblib
from distributed import Client, LocalCluster
from setcmas_tools import sweep
if __name__ == '__main__':
    cluster = LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with cluster, Client(cluster) as client, joblib.parallel_config('dask'):
        sweep('law.py', 5, 10, output='there', **{given!r})
        used = client.run(lambda: 'setcmas_tools.study.study_run' in sys.modules)
        assert all(used.values())
""")
    subprocess.run([sys.executable, 'study.py'], cwd=tmp_path, check=True)

    assert (tmp_path / 'there/runs.csv').read_bytes() == (here.folder / 'runs.csv').read_bytes()


def test_a_script_without_its_main_line_is_told_so(tmp_path):
    script = 'from setcmas_tools import sweep\nsweep("consensus", 2, 1, seeds=9, jobs=1)\n'
    (tmp_path / 'study.py').write_text(script)
    done = subprocess.run(
        [sys.executable, 'study.py'], cwd=tmp_path, capture_output=True, text=True
    )

    assert done.returncode == 1
    assert "must do so below a line if __name__ == '__main__':" in done.stderr.splitlines()[-1]
