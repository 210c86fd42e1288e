import signal
import subprocess
import sys

import pytest

pytest.importorskip('rclpy')

HANGS = """
import time
from setcmas_simu.ros.process import ros_process

with ros_process() as process:
    process.longest_end_s = 1
    process.executor.shutdown = lambda: time.sleep(600)
"""


def test_a_process_ends_whose_ros_never_does(domain):
    process = subprocess.run([sys.executable, '-c', HANGS], timeout=120, check=False)

    assert process.returncode == -signal.SIGALRM
