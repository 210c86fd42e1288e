import os
import subprocess
import sys
from pathlib import Path

import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_simu.simulator import duplicate_simulators
from setcmas_simu.simulator.duplicate_simulators import RobotLocks

HOLDER = """
import sys
from setcmas_simu.simulator.duplicate_simulators import RobotLocks
locks = RobotLocks([1, 2], '/a')
print('held', flush=True)
sys.stdin.read()
"""


@pytest.fixture
def holder(tmp_path, monkeypatch):
    monkeypatch.setenv('TMPDIR', str(tmp_path))
    monkeypatch.setattr('tempfile.tempdir', None)
    process = subprocess.Popen(
        [sys.executable, '-c', HOLDER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == 'held\n'
    yield process
    process.kill()
    process.communicate()


def test_robots_of_another_process_are_refused_and_it_is_named(holder):
    with pytest.raises(SetcmasError, match=f'robot 2 is already .* process {holder.pid} '):
        RobotLocks([2, 3], '/a')
    RobotLocks([3], '/a').release()


def test_other_robots_namespaces_and_domains_are_free(holder, monkeypatch):
    RobotLocks([3, 4], '/a').release()
    RobotLocks([1, 2]).release()
    monkeypatch.setenv('ROS_DOMAIN_ID', '99')
    RobotLocks([1, 2], '/a').release()


def link(path):
    path.symlink_to('/etc/passwd')


def pipe(path):
    os.mkfifo(path)


@pytest.mark.parametrize('obstruct', [link, pipe, os.mkdir])
def test_what_another_user_puts_in_the_place_of_the_locks_stops_no_simulator(
    tmp_path, monkeypatch, obstruct
):
    monkeypatch.setattr('tempfile.tempdir', str(tmp_path))
    monkeypatch.setenv('ROS_DOMAIN_ID', '7')
    obstruct(duplicate_simulators._path('7'))

    RobotLocks([1, 2]).release()


def test_any_number_of_robots_takes_one_file_and_one_descriptor(tmp_path, monkeypatch):
    monkeypatch.setattr('tempfile.tempdir', str(tmp_path))
    before = len(list(Path('/proc/self/fd').iterdir()))

    locks = RobotLocks(list(range(1, 2001)))

    assert len(list(Path('/proc/self/fd').iterdir())) == before + 1
    assert len(list(tmp_path.iterdir())) == 1
    locks.release()
