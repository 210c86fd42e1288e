"""Scripts that fail, hang, die, or change the process: rows that say so, and no other row."""

import os

import pytest

from setcmas_tools import sweep

pytestmark = pytest.mark.skipif(not hasattr(os, 'fork'), reason='runs share a process')

SCRIPT = """
import ctypes, math, os, subprocess, sys
import numpy
DOES = 'nothing'
ACTS = {
    'raises': 'raise ValueError("oh no")',
    'hangs': 'while True: pass',
    'exits': 'os._exit(3)',
    'crashes': 'ctypes.string_at(0)',
    'fills': 'hold = bytearray(10**13)',
    'forks': 'os.fork()',
    'moves': 'os.chdir("/")',
    'starts': 'subprocess.Popen(["sleep", "1000"])',
    'patches': 'math.atan2 = numpy.array = None',
    'closes': 'os.closerange(0, 100)',
    'prints': 'print("x" * 10**6)',
}
def control(robotNo, nbRobots, poses, t):
    if robotNo == 2 and 1 < t < 1.3:
        exec(ACTS.get(DOES, ''))
    return 0.1, 0.0
"""
EXPECTED = {
    'nothing': ('complete', '', ''),
    'raises': ('failed', '2', 'ValueError: oh no'),
    'hangs': ('died', '2', 'tb3_2: ended after 3 s (--timeout), in control'),
    'exits': ('died', '2', 'exit status 3'),
    'crashes': ('died', '2', 'killed by SIGSEGV'),
    'fills': ('failed', '2', 'MemoryError'),
    'forks': ('complete', '', ''),
    'moves': ('complete', '', ''),
    'starts': ('complete', '', ''),
    'patches': ('failed', '2', 'scripts cannot replace math.atan2'),
    'closes': ('died', '', 'exit status 1'),
    'prints': ('complete', '', ''),
    'ends': ('complete', '', ''),
}


@pytest.mark.nightly
def test_a_script_harms_its_own_run_alone(tmp_path):
    (tmp_path / 'law.py').write_text(SCRIPT)
    study = sweep(
        tmp_path / 'law.py', 2, 3, vary={'DOES': list(EXPECTED)}, jobs=2, timeout=3, seeds=1
    )
    first, *_, last = study['disagreement']

    assert first == last > 0
    for does, state, robots, message in zip(
        *(study[name] for name in ('DOES', 'state', 'robots', 'message')), strict=True
    ):
        expected = EXPECTED[does]
        assert (state, robots) == expected[:2], (does, message)
        assert expected[2] in message
