import os
import sys
import time
from pathlib import Path

import pytest
from processes import TIMEOUT_S

from launch_scripts.processes.supervisor import Supervisor

pytestmark = pytest.mark.skipif(sys.platform != 'linux', reason='processes are found in /proc')

DETACHES = """
import os, sys, time
if os.fork() == 0:
    os.setsid()
    if os.fork() == 0:
        open(sys.argv[1], 'w').write(str(os.getpid()))
        time.sleep(1000)
    os._exit(0)
time.sleep(1000)
"""


def test_a_process_that_a_child_has_detached_ends_with_the_rest(tmp_path):
    file = tmp_path / 'pid'
    with Supervisor(dict(os.environ)) as supervisor:
        supervisor.start('child', [sys.executable, '-c', DETACHES, str(file)])
        deadline = time.monotonic() + TIMEOUT_S
        supervisor.run(lambda: (file.exists() and file.read_text()) or time.monotonic() > deadline)
        pid = int(file.read_text())
        assert Path(f'/proc/{pid}').exists()

    assert not Path(f'/proc/{pid}').exists()
