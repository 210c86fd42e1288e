"""Fixtures for all tests: a ROS domain of one's own, processes that never outlive their test."""

import os
import shutil
import signal
import sys

import pytest
from ros_domain import reserved_domain

NIGHTLY_TIMEOUT_S = 1800
# Processes that tests start are to find compiled modules, as a user's do.
os.environ.pop('PYTHONDONTWRITEBYTECODE', None)
sys.dont_write_bytecode = False
# Matrices of a few robots gain nothing from the threads that every process would start.
os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
# A shell that starts the tests in the background has Ctrl-C ignored, by all their processes too.
signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_terminal_summary(terminalreporter, exitstatus):
    """Where nothing may be skipped (in CI), let a skipped test fail the whole run.

    SETCMAS_MAY_SKIP has words of the reasons of those that may be skipped on this machine.
    """
    allowed = os.environ.get('SETCMAS_MAY_SKIP', '').split()
    skipped = [
        report
        for report in terminalreporter.stats.get('skipped', [])
        if not any(word in str(report.longrepr) for word in allowed)
    ]
    if os.environ.get('SETCMAS_SKIP_NOTHING') and skipped and exitstatus == 0:
        terminalreporter._session.exitstatus = 1
        terminalreporter.write_line(f'{len(skipped)} tests were skipped; none may be', red=True)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items, config):
    """Mark tests that need ROS topics or more time; spread the former evenly over workers.

    They mostly wait: so that the processor has other tests to run meanwhile. For the same reason
    fixtures that take long belong to the session, not to a module.
    """
    groups = [], []
    for item in items:
        needs_ros = 'domain' in getattr(item, 'fixturenames', ())
        if needs_ros:
            item.add_marker(pytest.mark.ros)
        if item.get_closest_marker('nightly'):
            item.add_marker(pytest.mark.timeout(NIGHTLY_TIMEOUT_S))
        groups[needs_ros].append(item)
    if hasattr(config, 'workerinput'):
        places = [
            ((i + 0.5) / len(group), item) for group in groups for i, item in enumerate(group)
        ]
        items[:] = [item for _, item in sorted(places, key=lambda place: place[0])]


@pytest.fixture(autouse=True, scope='module')
def _restored_after_module():
    """Restore what scripts change that fixtures of a whole module run."""
    from processes import restored_process

    with restored_process():
        yield


@pytest.fixture(autouse=True)
def _restored_process():
    """Restore what a test's scripts change in this process."""
    from processes import restored_process

    with restored_process():
        yield


@pytest.fixture
def domain(monkeypatch):
    """Reserve a ROS domain that no other test on this machine uses at the same time."""
    with reserved_domain() as number:
        monkeypatch.setenv('ROS_DOMAIN_ID', str(number))
        monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
        yield number


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


@pytest.fixture(scope='session')
def needs_chromium():
    """Skip the test where there is no browser."""
    if not (shutil.which('chromium') and shutil.which('chromedriver')):
        pytest.skip('chromium or chromium-driver is missing')


@pytest.fixture
def peer(domain):
    """Take part in the test's ROS domain as a node of one's own."""
    pytest.importorskip('rclpy')
    from ros_peer import Peer

    with Peer(domain) as peer:
        yield peer
