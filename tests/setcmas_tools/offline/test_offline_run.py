"""Scripts that hang, die or break what they run in: the command keeps its word and its results."""

import os
import sys
import textwrap
import time

import pytest
from processes import SETCMAS, TIMEOUT_S

from setcmas_simu.errors import SetcmasError
from setcmas_tools.offline.offline_run import BrokenRun, OfflineRun
from setcmas_tools.scenario.scenario import Scenario

LAW = """
import os, signal, sys, threading, time, re
calls = 0
{top}
def control(robotNo, nbRobots, poses, t):
    global calls
    calls += 1
    if robotNo == 2 and calls == 3:
        {body}
    return 0.1, 0.0
"""


@pytest.fixture
def run(tmp_path):
    """Run a script in a process of its own; returns the outcome, what was told, and how long."""

    def run_script(body='pass', top='', call_timeout=3.0, **options):
        path = tmp_path / 'law.py'
        path.write_text(LAW.format(top=textwrap.dedent(top), body=body))
        said = []
        scenario = Scenario.of(path, **{'nb_robots': 3, 'duration': 4.0, **options})
        with OfflineRun(scenario.found()) as process:
            return process.result(call_timeout, said.append, lambda _: None), said

    return run_script


def test_a_run_that_goes_well_is_the_same_as_without_a_process(run, tmp_path):
    from setcmas_tools import simulate

    result, said = run()

    assert said == []
    assert (result.poses == simulate(tmp_path / 'law.py', 3, 4.0).poses).all()


def test_sets_of_strings_and_generators_without_a_seed_are_the_same_in_each_process(run):
    top = """
        import random
        import numpy as np
        rng = np.random.default_rng()
    """
    body = "return hash('x') % 10 + rng.random(), list({'a', 'b', 'c'}).index('a') + rng.random()"

    first, second = (run(body, top, vnom=float('inf'))[0].table for _ in range(2))

    assert (first.x == second.x).all()
    assert (first.y == second.y).all()


def test_a_run_that_a_script_starts_leaves_the_outer_run_and_its_limit_alone(run):
    top = """
        from setcmas_tools import simulate
        simulate('nav_wp', nb_robots=8, duration=20)
    """
    result, said = run(top=top)

    assert said == []
    assert result.poses.shape[1:] == (3, 3)

    endless, _ = run(top=f'{top}    while True: simulate("nav_wp", duration=1)', call_timeout=0.5)
    assert endless.reason.startswith('law.py has been loading for 0.5 s')


def nightly(*bodies):
    return [pytest.param(body, marks=pytest.mark.nightly) for body in bodies]


@pytest.mark.parametrize(
    'body',
    [
        'time.sleep(1000)',
        'signal.raise_signal(signal.SIGSTOP)',
        *nightly(
            'while True: pass',
            'sum(range(10 ** 14))',
            'threading.Lock().acquire() and threading.Event().wait()',
            '9 ** 9 ** 9',
            're.match("(a+)+$", "a" * 40 + "b")',
        ),
    ],
)
def test_a_call_that_does_not_return_is_reported_and_ended(run, body):
    result, said = run(body)

    assert isinstance(result, BrokenRun)
    assert result.robot == 2
    assert result.reason.startswith('control has not returned for 3 s (--call-timeout) at law.py')
    assert len(said) == 1
    assert said[0].startswith('tb3_2: control has not returned for 2 s')
    assert 'law.py, line 9\n    9 | ' in result.reason
    assert (result.file, result.line) == ('law.py', 9)
    assert 3 <= len(result.states) <= 7  # 0.4 s at 10 Hz


@pytest.mark.parametrize('body', ['while True: pass', 'sum(range(10 ** 14))'])
def test_a_short_limit_names_the_line_too(run, body):
    result, said = run(body, call_timeout=1.0)

    assert 'for 1 s (--call-timeout) at law.py, line 9\n    9 | ' in result.reason
    assert said == []


def test_a_call_that_swallows_everything_is_ended_too(run):
    body = 'exec("while True:\\n try:\\n  time.sleep(9)\\n except: pass")'

    result, _ = run(body, call_timeout=1.0)

    assert result.reason.startswith('control has not returned for 1 s')


def test_a_robot_that_does_not_step_is_reported_and_ended(run, tmp_path):
    robot = tmp_path / 'robot.py'
    robot.write_text('import time\ndef step(state, command, Ts):\n    time.sleep(1000)\n')

    result, said = run(model=f'3:{robot}')

    assert result.robot == 3
    assert result.reason.startswith('step has not returned for 3 s (--call-timeout) at robot.py')
    assert said[0].startswith('tb3_3: step has not returned for 2 s; it is at robot.py, line ')


def test_a_script_that_does_not_load_is_reported_and_ended(run):
    result, said = run(top='time.sleep(1000)')

    assert 'law.py has been loading for 3 s' in result.reason
    assert said[0].startswith('tb3_1: law.py has been loading for 2 s; it is at law.py, line 4')


@pytest.mark.parametrize(
    ('body', 'reason'),
    [
        ('os._exit(7)', 'ended its process with exit status 7'),
        (
            'os.kill(os.getpid(), signal.SIGKILL)',
            'killed by SIGKILL',
        ),
        ('import ctypes; ctypes.string_at(0)', 'killed by SIGSEGV'),
        ('os.abort()', 'killed by SIGABRT'),
    ],
)
def test_a_script_that_dies_is_reported_with_robot_and_line(run, body, reason):
    result, _ = run(body)

    assert isinstance(result, BrokenRun)
    assert result.robot == 2
    assert f'{reason} at law.py, line 9\n    9 | ' in result.reason
    assert len(result.states) >= 3


@pytest.mark.parametrize(
    'top',
    [
        'import atexit; atexit.register(time.sleep, 1000)',
        'class Odd:\n    def __del__(self): time.sleep(1000)\nodd = Odd()',
        'threading.Thread(target=time.sleep, args=(1000,)).start()',
        'import multiprocessing\n'
        'multiprocessing.get_context("fork").Process(target=time.sleep, args=(1000,)).start()',
        'import subprocess; subprocess.Popen(["sleep", "1000"], start_new_session=True)',
    ],
)
def test_what_a_script_leaves_behind_holds_nothing_up(run, top):
    begin = time.monotonic()
    result, _ = run(top=top)

    assert not isinstance(result, BrokenRun)
    assert time.monotonic() - begin < 500  # 1000 s is what it would take


@pytest.mark.parametrize(
    'body',
    [
        'sys.modules.clear(); import numpy; numpy.asarray = None; numpy.linspace = None',
        '__import__("builtins").len = None',
        'sys.stdout = sys.stderr = None',
        'sys.setrecursionlimit(30)',
        'sys.settrace(lambda *_: 1 / 0)',
        'os.chdir("/")',
        'os.closerange(0, 64)',
        'signal.alarm(1); time.sleep(1.5)',
        'raise KeyboardInterrupt',
    ],
)
def test_a_script_that_breaks_what_it_runs_in_loses_nothing(run, body):
    result, _ = run(body)

    if isinstance(result, BrokenRun):
        assert result.reason
        assert len(result.states) >= 3
    else:
        assert len(result.t) == 41


def test_a_fork_goes_on_once(run, tmp_path):
    result, _ = run(f'os.fork(); open({str(tmp_path / "pids")!r}, "a").write(f"{{os.getpid()}} ")')

    assert not isinstance(result, BrokenRun)
    for pid in (tmp_path / 'pids').read_text().split():
        assert not os.path.exists(f'/proc/{pid}')  # noqa: PTH110


@pytest.mark.skipif(sys.platform != 'linux', reason='the kernel ends the process there')
def test_a_command_that_is_killed_leaves_no_process(start, tmp_path):
    psutil = pytest.importorskip('psutil')
    law = tmp_path / 'law.py'
    law.write_text('def control(i, n, p, t):\n    print("here")\n    while True:\n        pass\n')
    command = start(*SETCMAS, 'offline', '--algo', str(law), '--call-timeout', '600')
    command.wait_for_output('here')
    [worker] = psutil.Process(command.pid).children()

    command.popen.kill()

    psutil.wait_procs([worker], timeout=TIMEOUT_S)
    assert not worker.is_running()


def test_mistakes_are_those_of_the_user(run):
    with pytest.raises(SetcmasError, match=r'law\.py, line 4: ZeroDivisionError'):
        run(top='1 / 0')


def test_scripts_cannot_be_asked_anything(run, capfd):
    result, _ = run('input("how much?")')

    assert result.failed_robots == [2]


@pytest.mark.skipif(sys.platform == 'win32', reason='signals')
def test_ctrl_c_is_answered_with_the_place(tmp_path):
    path = tmp_path / 'law.py'
    path.write_text(LAW.format(top='', body='time.sleep(1000)'))
    scenario = Scenario.of(path, nb_robots=3, duration=4.0)
    with OfflineRun(scenario.found()) as process:

        def press_ctrl_c(_):
            if 'line 9' in process.place():
                raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            process.result(TIMEOUT_S, print, press_ctrl_c)
        assert 'line 9' in process.place()
