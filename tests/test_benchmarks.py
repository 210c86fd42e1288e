"""Benchmarks: each works, with little of everything (--quick)."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip('rclpy')

BENCHMARKS = Path(__file__).parents[1] / 'benchmarks'
PROGRAMS = [
    path.stem for path in sorted(BENCHMARKS.glob('*.py')) if '__main__' in path.read_text()
]
ARGUMENTS = {'before_after': [sys.executable]}


@pytest.mark.nightly
@pytest.mark.parametrize('name', PROGRAMS)
def test_a_benchmark_prints_its_figures(name, tmp_path, domain):
    if name == 'view':
        pytest.importorskip('selenium')
    done = subprocess.run(
        [sys.executable, BENCHMARKS / f'{name}.py', '--quick', *ARGUMENTS.get(name, ())],
        cwd=tmp_path,
        env=os.environ | {'PYTHONUNBUFFERED': '1'},
        capture_output=True,
        text=True,
        check=False,
    )

    assert done.returncode == 0, done.stdout + done.stderr
    assert 'Traceback' not in done.stderr
    assert done.stdout.strip()
