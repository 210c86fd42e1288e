"""Tests of processes that run in the foreground."""

import subprocess
import sys


def test_a_supervisor_has_no_arrays_and_no_options():
    """They took 18 MB in each terminal of a student."""
    code = (
        'import sys, launch_scripts.processes.foreground\n'
        'names = ("numpy", "yaml", "setcmas_simu.options", "setcmas_expe", "setcmas_ctrl")\n'
        'print(*[name for name in names if name in sys.modules])'
    )
    loaded = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True)
    assert loaded.stdout.split() == []
    assert loaded.returncode == 0
