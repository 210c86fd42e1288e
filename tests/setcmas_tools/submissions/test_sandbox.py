"""Attacks of submissions on the grader: none gets a mark, or a byte of what it must not read."""

import ctypes
import os
import re
import socket
import threading
from contextlib import contextmanager
from pathlib import Path

import msgspec
import psutil
import pytest
from hostile_submissions import ENDS, GO_ON, SLOW, TRIES, WORK_WITHOUT, trying
from processes import TIMEOUT_S
from sandboxes import SHORT, needs_sandbox, run

from setcmas_simu.script_calls import Function
from setcmas_tools import simulate
from setcmas_tools.grade.submission_run import Times
from setcmas_tools.submissions import sandbox
from setcmas_tools.submissions.confined_program import RunWork
from setcmas_tools.submissions.sandbox import ConfinedProcess, NoProcessError, obstacle

pytestmark = needs_sandbox

STILL = 'def control(i, n, poses, t):\n    return 0.25, 0\n'


def still(i, n, poses, t):
    return 0.25, 0


@contextmanager
def answering(family, place):
    """A server that sends what a submission must not read; yields its place."""

    def answer_all():
        while True:
            try:
                with server.accept()[0] as one:
                    one.recv(10)
                    one.sendall(b'SECRET')
            except OSError:
                return

    with socket.socket(family, socket.SOCK_STREAM) as server:
        server.bind(place)
        server.listen()
        threading.Thread(target=answer_all, daemon=True).start()
        yield server.getsockname()
        server.shutdown(socket.SHUT_RDWR)  # or `accept` would keep the place


@pytest.mark.parametrize('is_confined', [True, False])
def test_nothing_that_a_submission_tries_works_in_the_sandbox(tmp_path, monkeypatch, is_confined):
    """Without the sandbox most of it works: so what is tried is no mistake of this test."""
    names = [*TRIES] if is_confined else sorted(WORK_WITHOUT)
    monkeypatch.setenv('SETCMAS_TEST', 'SECRET')
    for name in ('rubric.yaml', 'solution.py', 'marks.json'):
        (tmp_path / name).write_text('SECRET')
    libc, key = ctypes.CDLL(None), os.getpid()
    segment = libc.shmget(key, 64, 0o1666)
    once = SHORT.replace(nb_robots=1, duration=0.1)
    with (
        answering(socket.AF_UNIX, f'\0setcmas{key}') as abstract,
        answering(socket.AF_INET, ('127.0.0.1', 0)) as tcp,
    ):
        script = trying(
            [TRIES[name] for name in names], PLACE=str(tmp_path), GRADER=os.getpid(), KEY=key,
            USER_HOME=str(Path.home()), CHECKOUT=str(Path(__file__).parents[3]),
            ABSTRACT=abstract, TCP=tcp[1],
        )  # fmt: skip
        failure = run(script, once, Times(20.0, 60.0), is_confined=is_confined).failure
    libc.shmctl(segment, 0, None)

    [numbers] = re.findall(r'worked: ([\d ]*)\.', failure.message)
    worked = {names[int(number)] for number in numbers.split()}
    assert worked == (set() if is_confined else WORK_WITHOUT)
    assert not Path.home().joinpath('.setcmas_forged').exists()
    assert ((tmp_path / 'marks.json').read_text() == 'SECRET') is is_confined


QUICK = {'exit', 'huge length', 'closed', 'loop', 'output'}
SUBMISSIONS = [
    pytest.param(*each, times, is_complete, marks=() if name in QUICK else pytest.mark.nightly)
    for table, times, is_complete in (
        (ENDS, None, False), (SLOW, Times(9.0, 3.0), False), (GO_ON, None, True)
    )
    for name, each in table.items()
]  # fmt: skip


@pytest.mark.parametrize(('body', 'message', 'times', 'is_complete'), SUBMISSIONS)
def test_what_a_submission_does_to_its_process_is_named_and_leaves_nothing(
    body, message, times, is_complete
):
    before = {*psutil.Process().children(recursive=True)}
    if 'for 1 s' in message:
        times = Times(1.0, 3.0)

    done = run(f'def control(i, n, poses, t):\n{body}\n', times=times)

    assert message in done.failure.message
    assert done.is_complete is is_complete
    left = {*psutil.Process().children(recursive=True)} - before
    assert not psutil.wait_procs(left, timeout=TIMEOUT_S)[1]


def test_processor_time_is_limited_too():
    script = (
        'import os, signal, struct\nsignal.setitimer = None\ndef control(i, n, poses, t):\n'
        '    while True: pass\n'
    )

    done = run(script, times=Times(9.0, 1.0))

    reason, _, _ = done.failure.message.partition(' (law.py')
    assert reason in ('the run takes longer than 1 s', 'the script took too much processor time')


def test_what_a_submission_forges_in_its_process_changes_it_alone():
    script = (
        'import sys\nimport numpy as np\nimport setcmas_ctrl.saturation as s\n'
        'vars(np).update(hypot=None, maximum=None)\ns.saturate = sys.stdout = None\n'
    )

    assert (run(script + STILL).run.poses == simulate(SHORT, algo=still).poses).all()


def test_nothing_of_a_run_is_left_for_the_next():
    script = (
        'import os\nassert not os.path.exists("/tmp/log")\nopen("/tmp/log", "w")\n'
        'open(os.path.expanduser("~/other"), "x").write("x" * 99)\n'
    )
    scenario = SHORT.replace(nb_robots=1)

    for _ in range(2):
        assert run(script + STILL, scenario).failure is None


def test_a_confined_process_ends_with_the_grader():
    waiting = RunWork('law.py', {}, Function.CONTROL, 1, 0, {}, 60)
    with ConfinedProcess(True, msgspec.msgpack.encode(waiting)) as process:
        before = psutil.Process(process._process.pid).children(recursive=True)
        assert before
        process._process.kill()
        left = psutil.wait_procs(before, timeout=TIMEOUT_S)[1]
        assert {one.status() for one in left} <= {psutil.STATUS_ZOMBIE}


def test_a_run_that_the_machine_has_ended_is_repeated_once(monkeypatch):
    begun, faults = ConfinedProcess.__init__, iter([1])

    def disturbed(self, *args):
        begun(self, *args)
        if next(faults, None):
            self._kill()

    monkeypatch.setattr(ConfinedProcess, '__init__', disturbed)

    assert run(STILL).failure is None


def test_a_process_that_does_not_start_is_the_fault_of_the_machine(monkeypatch):
    monkeypatch.setattr(sandbox, 'confining_command', lambda: ['false'])

    with pytest.raises(NoProcessError, match='this computer cannot run more processes'):
        run(STILL)


@pytest.fixture
def path(tmp_path, monkeypatch):
    """A folder that is the whole search path for commands."""
    monkeypatch.setenv('PATH', str(tmp_path))
    sandbox.confining_command.cache_clear()
    yield tmp_path
    sandbox.confining_command.cache_clear()


def write_command(path, name, script):
    (path / name).write_text(f'#!/bin/sh\n{script}\n')
    (path / name).chmod(0o755)


@pytest.mark.parametrize(
    ('command', 'script', 'message'),
    [
        (
            'apt-get',
            '',
            'to install it: sudo apt-get install bubblewrap, or use Docker',
        ),
        ('none', '', 'bubblewrap is missing; to install it: install bubblewrap, or use Docker'),
        ('bwrap', 'setting up uid map: Permission denied', 'sudo apparmor_parser -r /etc/appar'),
        ('bwrap', 'Unknown option --disable-userns', 'bubblewrap 0.8 or later is needed'),
    ],
)
def test_where_submissions_cannot_be_confined_the_remedy_is_named(
    path, monkeypatch, command, script, message
):
    (path / 'restricted').write_text('1\n')
    monkeypatch.setattr(sandbox, '_RESTRICTED', path / 'restricted')
    write_command(path, command, f'echo "bwrap: {script}" >&2; exit 1')

    assert message in obstacle()
    (path / 'restricted').write_text('0\n')
    if 'denied' in script:
        assert 'in Docker, add --security-opt seccomp' in obstacle()
    monkeypatch.setattr(sandbox.sys, 'platform', 'win32')
    assert obstacle() == 'bubblewrap runs on Linux only; use Docker or, on Windows, WSL 2'
