import os
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import psutil
import pytest
from processes import TIMEOUT_S, gone

from launch_scripts.processes import ChildDiedError
from launch_scripts.supervisor import StoppedError, Supervisor
from setcmas_simu.reports import Ready, Started
from setcmas_simu.script_calls import Function, ScriptCall

pytestmark = pytest.mark.skipif(sys.platform != 'linux', reason='children end with it there')

SLEEPER = 'import time; print("ready", flush=True); time.sleep(600)'
STUBBORN = 'import signal; signal.signal(signal.SIGTERM, signal.SIG_IGN); ' + SLEEPER
PARENT = 'import subprocess, sys; subprocess.Popen([sys.executable, "-c", {!r}]); {}'


def python(code):
    return [sys.executable, '-c', code]


@pytest.fixture
def supervisor():
    with Supervisor(dict(os.environ), prefix=True) as supervisor:
        supervisor.lines = []
        supervisor.write = lambda line, _: supervisor.lines.append(line)
        yield supervisor


def wait_until(condition):
    deadline = time.monotonic() + TIMEOUT_S
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.02)


@pytest.mark.parametrize(
    ('end', 'reason', 'status'),
    [
        ('os._exit(3)', 'ended unexpectedly with exit status 3', 3),
        ('os.kill(os.getpid(), 9)', 'was killed by SIGKILL', 137),
        ('print("error: x", flush=True); os._exit(2)', 'unexpectedly with exit status 2', 2),
    ],
)
def test_a_process_that_dies_is_named_with_the_reason(supervisor, end, reason, status):
    supervisor.start('good', python(SLEEPER))
    bad = supervisor.start('bad', python('import os; ' + end))

    named = rf'bad \(process {bad.process.pid}\).* {reason}'
    with pytest.raises(ChildDiedError, match=named) as caught:
        supervisor.run()
    assert caught.value.exit_status == status


SETUP = 'from setcmas_simu.reports import connected_launcher as launcher\n'
SETUP += 'from setcmas_simu.reports import *\n'
SETUP += 'from setcmas_simu.script_calls import Function\n'


def test_a_mistake_that_a_process_has_reported_is_not_repeated(supervisor):
    code = (
        'print("error: because of this"); launcher().report(Mistake("this")); raise SystemExit(2)'
    )
    supervisor.start('bad', python(SETUP + code))

    with pytest.raises(ChildDiedError) as caught:
        supervisor.run()
    assert supervisor.lines == ['[bad] error: because of this']
    assert caught.value.exit_status == 2
    assert str(caught.value) == ''


def test_what_a_process_reports_is_not_what_it_prints(supervisor):
    code = (
        'import os; t = launcher(); print("controlling robots"); t.report(Started((1, 2), "law"))'
    )
    child = supervisor.start('one', python(SETUP + code + '\n' + SLEEPER))
    supervisor.run(until=lambda: child.reported(Started))

    assert child.reported(Started) == Started((1, 2), 'law')
    assert child.reported(Ready) is None
    assert not any('Started' in line for line in supervisor.lines)


IN_A_CALL = (
    SETUP
    + """
import os, signal, time
from pathlib import Path
signal.signal(signal.SIGTERM, lambda *_: None)  # as nodes do: it is answered between two calls
launcher = launcher()
launcher.report(Ready())
launcher.current_call.begin(2, Path('law.py'), Function.CONTROL)
launcher.current_call.since -= {ago}
"""
)
CALL = ScriptCall(2, 'law.py', Function.CONTROL)


ENDS = 'launcher.current_call.end()\n'


@pytest.mark.parametrize(
    ('end', 'reason', 'status', 'failed'),
    [
        ('os._exit(0)', 'unexpectedly with exit status 0.* in control of law.py for', 1, (CALL,)),
        ('os.kill(os.getpid(), 9)', 'by SIGKILL.* in control of law.py for tb3_2', 1, (CALL,)),
        (ENDS, 'status 0 after control of law.py for tb3_2', 0, ()),
    ],
)
def test_a_process_that_dies_in_a_call_is_named_with_robot_and_script(
    supervisor, end, reason, status, failed
):
    child = supervisor.start('ctrl', python(IN_A_CALL.format(ago=0) + end))

    with pytest.raises(ChildDiedError, match=reason) as caught:
        supervisor.run()
    assert caught.value.exit_status == 1
    assert (child.exit_status, child.failed) == (status, failed)


def test_what_a_start_waits_for_is_the_call_that_hangs(supervisor):
    code = IN_A_CALL.format(ago=0).replace('CONTROL', 'LOADING') + 'print("in it", flush=True)\n'
    child = supervisor.start('ctrl', python(code + 'time.sleep(600)'))
    assert child.missing == 'the controllers have not called their laws'
    supervisor.run(until=lambda: supervisor.lines)

    assert child.missing == 'loading of law.py for tb3_2 has not returned'
    assert child.failed == ()


def test_a_call_that_silences_its_process_is_reported_and_ended(supervisor):
    child = supervisor.start('ctrl', python(IN_A_CALL.format(ago=9) + 'os.kill(os.getpid(), 19)'))
    supervisor.run(until=lambda: supervisor.lines)
    supervisor.stop(child)

    assert 'ctrl does not answer: control of law.py for tb3_2' in supervisor.lines[0]
    assert 'killed in control of law.py for tb3_2' in supervisor.lines[1]
    assert child.exit_status == 1
    assert child.failed == (CALL,)


def test_a_reader_that_does_not_read_delays_neither_children_nor_a_stop(tmp_path):
    path = tmp_path / 'done'
    talker = f'print(("x" * 99 + "\\n") * 20_000); open({str(path)!r}, "w"); {SLEEPER}'
    code = (
        'import os, sys\n'
        'from launch_scripts.supervisor import StoppedError, Supervisor\n'
        f'with Supervisor(dict(os.environ)) as s:\n    s.start("child", {python(talker)!r})\n'
        '    try:\n        s.run()\n    except StoppedError:\n        pass\n'
    )
    launcher = subprocess.Popen(python(code), stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    wait_until(path.exists)  # 2 MB are written, although the reader does not read
    (child,) = psutil.Process(launcher.pid).children()

    launcher.send_signal(signal.SIGTERM)

    assert launcher.wait(TIMEOUT_S) == 0
    wait_until(lambda: gone(child.pid))
    launcher.stdout.close()


def test_even_a_stubborn_process_is_stopped_with_all_that_it_started(supervisor):
    grandchildren = 'print("ready", flush=True); import time; time.sleep(600)'
    child = supervisor.start('child', python(PARENT.format(STUBBORN, grandchildren)))
    supervisor.run(until=lambda: len(supervisor.lines) == 2)
    family = [child.process.pid, *[p.pid for p in psutil.Process(child.process.pid).children()]]
    assert len(family) == 2

    supervisor.stop(child)

    wait_until(lambda: all(map(gone, family)))


def test_a_process_that_is_stopped_before_it_handles_signals_has_not_failed(supervisor):
    child = supervisor.start('child', python('import time; time.sleep(600)'))
    supervisor.stop(child)

    assert child.process.returncode == -signal.SIGTERM
    assert child.exit_status == 0


@pytest.mark.parametrize(
    ('report', 'writes_s', 'status'), [('Recording(2)', 1, 0), ('Ready()', 600, -signal.SIGKILL)]
)
def test_only_a_recorder_gets_the_time_to_write(supervisor, monkeypatch, report, writes_s, status):
    monkeypatch.setattr('launch_scripts.supervisor._ENDS_S', 0.2)
    writes = (
        'import signal, sys, time\n'
        f'signal.signal(signal.SIGTERM, lambda *_: (time.sleep({writes_s}), sys.exit(0)))\n'
    )
    code = f'{SETUP}{writes}launcher().report({report})\n{SLEEPER}'
    child = supervisor.start('record', python(code))
    supervisor.run(until=lambda: supervisor.lines)
    supervisor.stop(child)

    assert child.process.returncode == status


def test_a_signal_asks_to_stop(supervisor):
    supervisor.start('child', python(SLEEPER))
    supervisor.run(until=lambda: supervisor.lines)
    os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(StoppedError):
        supervisor.run()


def test_handlers_of_signals_are_given_back():
    before = signal.getsignal(signal.SIGINT)
    with Supervisor({}):
        assert signal.getsignal(signal.SIGINT) != before
    assert signal.getsignal(signal.SIGINT) == before


LAUNCHER = textwrap.dedent(
    """
    import os, sys
    from launch_scripts.supervisor import Supervisor
    with Supervisor(dict(os.environ)) as supervisor:
        child = supervisor.start('child', [sys.executable, '-c', {code!r}])
        open({path!r}, 'w').write(str(child.process.pid))
        supervisor.run()
    """
)


@pytest.mark.parametrize('signum', [signal.SIGKILL, signal.SIGHUP])
def test_when_the_launcher_dies_nothing_is_left(tmp_path, signum):
    path = tmp_path / 'pid'
    launcher = subprocess.Popen(
        python(LAUNCHER.format(code=SLEEPER, path=str(path))),
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
    assert launcher.stdout.readline() == b'ready\n'
    child = int(Path(path).read_text())
    assert not gone(child)

    launcher.send_signal(signum)
    launcher.wait()
    launcher.stdout.close()

    wait_until(lambda: gone(child))
