"""Attacks of submissions on the grader: none gets a mark, or a byte of what it must not read."""

import ctypes
import os
import re
import socket
import threading
from dataclasses import replace
from pathlib import Path

import msgspec
import psutil
import pytest
from hostile_submissions import (
    ENDS,
    GO_ON,
    PACKED,
    SLOW,
    TRIES,
    WORK_WITHOUT,
    archive,
    trying,
)
from processes import TIMEOUT_S
from sandboxes import SHORT, needs_sandbox, run

from setcmas_simu.script_calls import Function
from setcmas_tools import simulate
from setcmas_tools.grade.class_grading import read_apart
from setcmas_tools.grade.submission_run import Times
from setcmas_tools.submissions import sandbox
from setcmas_tools.submissions.confined_program import RUN, RunWork
from setcmas_tools.submissions.sandbox import ConfinedProcess, NoProcessError, obstacle
from setcmas_tools.submissions.submissions import Packed, Submission
from setcmas_tools.submissions.submitted_files import Student

pytestmark = needs_sandbox

CHECKOUT = str(Path(__file__).parents[3])
STILL = 'def control(i, n, poses, t):\n    return 0.25, 0\n'


def still(i, n, poses, t):
    return 0.25, 0


@pytest.fixture(scope='session')
def place(tmp_path_factory):
    """A folder with what submissions must neither read nor change."""
    folder = tmp_path_factory.mktemp('class')
    (folder / 'class').mkdir()
    for name in ('rubric.yaml', 'solution.py', 'hidden.yaml', 'class/ada.py', 'marks.json'):
        (folder / name).write_text('SECRET')
    return folder


@pytest.fixture(scope='session')
def known(place):
    """What a hostile submission knows of this machine, with servers that answer."""
    servers = []

    def answer_all(server):
        while True:
            try:
                with server.accept()[0] as one:
                    one.recv(10)
                    one.sendall(b'SECRET')
            except OSError:
                return

    def listen(family, at):
        server = socket.socket(family, socket.SOCK_STREAM)
        servers.append(server)
        server.bind(at)
        server.listen()
        threading.Thread(target=answer_all, args=(server,), daemon=True).start()
        return server.getsockname()

    abstract = f'\0setcmas{os.getpid()}'
    listen(socket.AF_UNIX, abstract)
    libc, key = ctypes.CDLL(None), os.getpid()
    segment = libc.shmget(key, 64, 0o1666)
    yield {
        'PLACE': str(place), 'GRADER': os.getpid(), 'USER_HOME': str(Path.home()),
        'CHECKOUT': CHECKOUT, 'ABSTRACT': abstract, 'KEY': key,
        'TCP': listen(socket.AF_INET, ('127.0.0.1', 0))[1],
    }  # fmt: skip
    libc.shmctl(segment, 0, None)
    for server in servers:
        server.close()


def worked(names, known, is_confined):
    script = trying([TRIES[name] for name in names], **known)
    once = SHORT.replace(nb_robots=1, duration=0.1)
    failure = run(script, once, Times(20.0, 60.0), is_confined=is_confined).failure
    numbers = re.search(r'worked: ([\d ]*)\.', failure.message)
    assert numbers, failure.message
    return {names[int(number)] for number in numbers[1].split()}


@pytest.fixture(scope='session')
def worked_in_it(known):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv('SETCMAS_TEST', 'SECRET')
        return worked([*TRIES], known, is_confined=True)


@pytest.fixture(scope='session')
def worked_without(known, place):
    found = worked(sorted(WORK_WITHOUT), known, is_confined=False)
    for name in ('class/ada.py', 'marks.json'):
        (place / name).write_text('SECRET')
    return found


@pytest.mark.parametrize('name', TRIES)
def test_what_a_submission_tries_does_not_work(worked_in_it, place, name):
    assert name not in worked_in_it
    assert not Path.home().joinpath('.setcmas_forged').exists()
    for file in ('class/ada.py', 'marks.json'):
        assert (place / file).read_text() == 'SECRET'


@pytest.mark.parametrize('name', sorted(WORK_WITHOUT))
def test_it_works_without_the_sandbox(worked_without, name):
    assert name in worked_without


def is_named(body, message, times=None):
    """Check that a submission is reported, and that nothing of it is left."""
    before = {*psutil.Process().children(recursive=True)}
    done = run(f'def control(i, n, poses, t):\n{body}\n', times=times)

    assert message in done.failure.message
    left = {*psutil.Process().children(recursive=True)} - before
    assert not psutil.wait_procs(left, timeout=TIMEOUT_S)[1]
    return done


QUICK = {'exit', 'huge length', 'closed', 'loop', 'output'}


def some(table):
    marks = {False: pytest.mark.nightly}
    return [pytest.param(name, marks=marks.get(name in QUICK, ())) for name in table]


@pytest.mark.parametrize('name', some(ENDS))
def test_a_submission_that_ends_its_process_or_forges_replies_ends_its_run(name):
    assert not is_named(*ENDS[name]).is_complete


@pytest.mark.parametrize('name', some(SLOW))
def test_a_submission_that_takes_too_long_is_ended(name):
    call_s = 9.0 if name == 'slow' else 1.0  # each of its calls returns in time
    assert not is_named(*SLOW[name], Times(call_s, 3.0)).is_complete


@pytest.mark.parametrize('name', some(GO_ON))
def test_a_submission_that_fails_goes_on_alone(name):
    assert is_named(*GO_ON[name]).is_complete


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
    with ConfinedProcess(True, RUN + msgspec.msgpack.encode(waiting)) as process:
        before = psutil.Process(process._process.pid).children(recursive=True)
        assert before
        process._process.kill()
        left = psutil.wait_procs(before, timeout=TIMEOUT_S)[1]
        assert {one.status() for one in left} <= {psutil.STATUS_ZOMBIE}


def packed(name, content):
    return Packed(name, Student('Ada'), Function.CONTROL, files={name: content})


@pytest.mark.parametrize('name', PACKED)
def test_a_file_that_attacks_whoever_unpacks_it_costs_its_student_alone(name):
    content, reason = PACKED[name]

    read = read_apart(packed(name, content))

    assert reason in read.problem
    assert read.student.name == 'Ada'


def test_what_cannot_be_read_beside_a_law_is_left_out():
    read = read_apart(packed('a.zip', archive({'law.py': STILL, 'old.zip': 'no zip file'})))

    assert (read.problem, read.files.keys()) == ('', {'law.py'})


@pytest.mark.parametrize('answer', [b'', b'\xff', b'\x91' * 9999])
def test_a_forged_submission_is_none(monkeypatch, answer):
    monkeypatch.setattr(ConfinedProcess, 'answer', lambda *_: answer)

    read = read_apart(packed('ada.zip', archive({'law.py': STILL})))

    assert read.problem == 'it cannot be unpacked'
    assert read.student.name == 'Ada'


def test_what_is_read_of_a_submission_is_not_anothers(monkeypatch):
    """A file that has taken over the process that unpacks it can answer whatever it likes."""
    forged = Submission('eve.zip', Student('Eve'), 'law.py', {'law.py': STILL.encode()})
    answer = msgspec.msgpack.encode(forged)
    monkeypatch.setattr(ConfinedProcess, 'answer', lambda *_: answer)

    read = read_apart(packed('ada.zip', archive({'law.py': STILL})))

    assert read == replace(forged, name='ada.zip', student=Student('Ada'))


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
    ('manager', 'command'),
    [('apt-get', 'sudo apt-get install bubblewrap'), ('none', 'install bubblewrap')],
)
def test_where_bubblewrap_is_missing_the_command_that_installs_it_is_named(path, manager, command):
    write_command(path, manager, '')

    assert obstacle() == f'bubblewrap is missing; to install it: {command}, or use Docker'


@pytest.mark.parametrize(
    ('restricted', 'error', 'remedy'),
    [
        ('1', 'setting up uid map: Permission denied', 'sudo apparmor_parser -r /etc/apparmor.d'),
        ('0', 'No permissions to create new namespace', 'in Docker, add --security-opt seccomp'),
        ('1', 'Unknown option --disable-userns', 'bubblewrap 0.8 or later is needed'),
    ],
)
def test_where_it_may_make_no_namespaces_the_remedy_is_named(
    path, monkeypatch, restricted, error, remedy
):
    (path / 'restricted').write_text(f'{restricted}\n')
    monkeypatch.setattr(sandbox, '_RESTRICTED', path / 'restricted')
    write_command(path, 'bwrap', f'echo "bwrap: {error}" >&2; exit 1')

    assert re.fullmatch(f'{error}; .*{remedy}.*', obstacle())


def test_elsewhere_docker_or_wsl_is_named(monkeypatch):
    monkeypatch.setattr(sandbox.sys, 'platform', 'win32')

    assert obstacle() == 'bubblewrap runs on Linux only; use Docker or, on Windows, WSL 2'
