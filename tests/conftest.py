"""Fixtures for all tests: a ROS domain of one's own, processes that never outlive their test."""

import fcntl
import os
import random
import tempfile
from pathlib import Path

import pytest

if os.environ.get('SETCMAS_REQUIRE_ROS'):
    import rclpy  # noqa: F401  # node tests are skipped without ROS; in CI they must run

DOMAINS = range(1, 102)  # the domain IDs that are safe on every system


@pytest.fixture
def domain(monkeypatch):
    """Reserve a ROS domain that no other test on this machine uses at the same time."""
    for number in random.sample(DOMAINS, len(DOMAINS)):
        path = Path(tempfile.gettempdir()) / f'setcmas_test_domain_{number}.lock'
        with path.open('w') as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            monkeypatch.setenv('ROS_DOMAIN_ID', str(number))
            monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
            yield number
            return
    raise RuntimeError('every ROS domain is in use')


@pytest.fixture
def start(tmp_path_factory, domain):
    """Start commands in the test's ROS domain; what still runs at the end is killed."""
    from processes import Process

    processes = []

    def start_process(*command, cwd=None, env=None):
        log = tmp_path_factory.mktemp('log') / 'output.txt'
        process = Process(command, log, cwd, {**os.environ, **(env or {})})
        processes.append(process)
        return process

    yield start_process
    for process in processes:
        process.kill_group()


@pytest.fixture
def peer(domain):
    """Take part in the test's ROS domain as a node of one's own."""
    pytest.importorskip('rclpy')
    from ros_peer import Peer

    with Peer(domain) as peer:
        yield peer
