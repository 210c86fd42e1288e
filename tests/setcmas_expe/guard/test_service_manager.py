"""The guard as a service of systemd: ready once it can stop its robot, and then watched."""

import os
import shutil
import socket
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip('rclpy')

from setcmas_expe.guard.guard_node import notify

pytestmark = pytest.mark.skipif(sys.platform != 'linux', reason='no systemd')

ROOT = Path(__file__).parents[3]
UNIT = ROOT / 'setcmas_expe' / 'systemd' / 'cmd_vel_guard@.service'
SCRIPT = ROOT / 'tests' / 'setcmas_expe' / 'scripts' / 'under_systemd.sh'
GUARD = [sys.executable, '-m', 'setcmas_expe.guard.guard_node']
NAMESPACES = '--mount --pid --fork --mount-proc --cgroup --propagation private'
WATCHDOGS_S = 5  # several times WatchdogSec


def test_systemd_is_told_first_that_the_guard_is_ready_and_then_that_it_works(start, tmp_path):
    address = str(tmp_path / 'notify')
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as systemd:
        systemd.bind(address)
        start(*GUARD, '--ros-args', '-r', '__ns:=/tb3_1', env={'NOTIFY_SOCKET': address})
        systemd.settimeout(120.0)
        assert [systemd.recv(100) for _ in range(3)] == [b'READY=1', b'WATCHDOG=1', b'WATCHDOG=1']


def test_a_systemd_that_has_ended_does_no_harm(tmp_path, monkeypatch):
    monkeypatch.setenv('NOTIFY_SOCKET', str(tmp_path / 'gone'))
    notify('WATCHDOG=1')


@pytest.mark.nightly
def test_the_service_starts_under_systemd_and_is_restarted_only_when_it_hangs(domain):
    if os.geteuid() != 0 or not shutil.which('systemctl') or not shutil.which('unshare'):
        pytest.skip('systemd: it is not installed, or needs root here')
    command = ['bash', str(SCRIPT), str(UNIT), 'tb3_1', str(WATCHDOGS_S), *GUARD]
    arguments = ['--ros-args', '-r', '__ns:=/%i']
    done = subprocess.run(
        ['unshare', *NAMESPACES.split(), *command, *arguments],
        capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    if done.returncode == 3 or 'mount:' in done.stderr or 'unshare:' in done.stderr:
        pytest.skip(f'systemd: it does not run here: {done.stdout}{done.stderr}')

    said = dict(line.split(': ', 1) for line in done.stdout.splitlines() if ': ' in line)
    assert said['started'].split() == ['NRestarts=0', 'ActiveState=active'], done.stderr
    assert said['later'] == said['started']
    assert said['hung'].split() == ['NRestarts=1', 'ActiveState=active']
