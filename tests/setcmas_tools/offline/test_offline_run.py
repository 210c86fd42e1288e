"""Scripts that hang, die or break what they run in: the command keeps its word and its results."""

import sys
import textwrap
import time

import psutil
import pytest
from processes import SETCMAS, TIMEOUT_S, gone

from setcmas_simu.errors import SetcmasError
from setcmas_simu.script_calls import Function
from setcmas_tools.offline.offline_run import OfflineRun
from setcmas_tools.run.run_info import RunState
from setcmas_tools.run.scenario import Scenario

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
    """Run a script in a process of its own; returns the run, and what was told."""

    def run_script(body='pass', top='', call_timeout=3.0, **options):
        path = tmp_path / 'law.py'
        path.write_text(LAW.format(top=textwrap.dedent(top), body=body))
        said = []
        scenario = Scenario.of(path, **{'nb_robots': 3, 'duration': 4.0, **options})
        with OfflineRun(scenario.found()) as process:
            return process.result(said.append, call_timeout), said

    return run_script


def reason(run):
    """Return why a script has ended a run."""
    assert run.outcome.state is RunState.DIED
    return run.outcome.detail


def test_a_run_that_goes_well_is_the_same_as_without_a_process(run, tmp_path):
    from setcmas_tools import simulate

    result, said = run()

    assert said == []
    assert (result.poses == simulate(tmp_path / 'law.py', 3, 4.0).poses).all()


def test_what_a_script_prints_is_shown_where_the_command_runs(run, capsys):
    run('print("here"); sys.stderr.write("half a line")')

    printed = capsys.readouterr()
    assert printed.out == 'tb3_2: here\n'
    assert printed.err.strip() == 'tb3_2: half a line'


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
    assert reason(endless).startswith('tb3_1: law.py has been loading for 0.5 s')


@pytest.mark.parametrize(
    'body',
    [
        'time.sleep(1000)',
        pytest.param('9 ** 9 ** 9', marks=pytest.mark.nightly),  # in C, until it returns
    ],
)
def test_a_call_that_does_not_return_is_reported_and_ended(run, body):
    result, said = run(body)

    late = 'tb3_2: control has not returned for'
    assert reason(result).startswith(f'{late} 3 s (--call-timeout) at law.py, line 9\n    9 | ')
    assert len(said) == 1
    assert said[0].startswith(f'{late} 2 s; it is at law.py, line 9')
    [failure] = result.info.failures
    assert (failure.robot, failure.script, failure.line) == (2, 'law.py', 9)
    assert failure.function is Function.CONTROL
    assert 3 <= len(result.t) <= 7  # 0.4 s at 10 Hz


def test_the_time_for_which_the_user_has_stopped_the_command_is_none_of_its_script(tmp_path):
    (tmp_path / 'law.py').write_text(
        "def control(i, n, p, t):\n    print('x' * 100_000)\n    return 0.1, 0.0\n"
    )
    stops = iter([1.5])

    def look():
        time.sleep(next(stops, 0.0))  # as after Ctrl-Z; the script waits for who takes its output

    with OfflineRun(Scenario.of(tmp_path / 'law.py', duration=2.0).found()) as process:
        result = process.result(print, call_timeout=0.5, look=look)
    assert result.outcome.state is RunState.COMPLETE


def test_a_robot_that_does_not_step_is_reported_and_ended(run, tmp_path):
    robot = tmp_path / 'robot.py'
    robot.write_text('import time\ndef step(state, command, Ts):\n    time.sleep(1000)\n')

    result, said = run(model=f'3:{robot}')

    late = 'tb3_3: step has not returned for 3 s (--call-timeout) at robot.py'
    assert reason(result).startswith(late)
    assert result.outcome.failed == {'robot.py': [3]}
    assert said[0].startswith('tb3_3: step has not returned for 2 s; it is at robot.py, line ')


def test_a_script_that_does_not_load_is_reported_and_ended(run):
    result, said = run(top='time.sleep(1000)')

    assert 'law.py has been loading for 3 s' in reason(result)
    assert said[0].startswith('tb3_1: law.py has been loading for 2 s; it is at law.py, line 4')


LINE_9 = ' at law.py, line 9\n    9 | '


@pytest.mark.parametrize(
    ('body', 'cause', 'place'),
    [
        ('os._exit(7)', 'ended its process with exit status 7', ', in control of law.py'),
        ('import ctypes; ctypes.string_at(0)', 'was killed by SIGSEGV', LINE_9),
    ],
)
def test_a_script_that_dies_is_reported_with_robot_and_script(run, body, cause, place):
    result, _ = run(body)

    assert reason(result).startswith('tb3_2: the ')
    assert f'{cause}{place}' in reason(result)
    assert result.outcome.failed == {'law.py': [2]}
    assert result.parameters['algo'] == 'inputs/algo/law.py'
    assert result.inputs[0].path.name == 'law.py'
    assert len(result.t) >= 3


@pytest.mark.parametrize(
    'top',
    [
        'import atexit; atexit.register(time.sleep, 1000)',
        'threading.Thread(target=time.sleep, args=(1000,)).start()',
        'import multiprocessing\n'
        'multiprocessing.get_context("fork").Process(target=time.sleep, args=(1000,)).start()',
        'import subprocess; subprocess.Popen(["sleep", "1000.25"], start_new_session=True)',
    ],
)
def test_what_a_script_leaves_behind_holds_nothing_up(run, top):
    result, _ = run(top=top)  # not after 1000 s, pytest's time-out

    assert result.outcome.state is RunState.COMPLETE
    for process in psutil.process_iter(['cmdline']):
        if process.info['cmdline'] == ['sleep', '1000.25']:  # in a session of its own
            process.kill()


@pytest.mark.parametrize(
    'body',
    [
        'sys.modules.clear(); import numpy; numpy.asarray = None; numpy.linspace = None',
        'sys.stdout = sys.stderr = None',
        'os.chdir("/")',
        'os.closerange(0, 64)',
        'raise KeyboardInterrupt',
    ],
)
def test_a_script_that_breaks_what_it_runs_in_loses_nothing(run, body):
    result, _ = run(body)

    if result.outcome.state is RunState.DIED:
        assert reason(result)
        assert len(result.t) >= 3
    else:
        assert len(result.t) == 41


def ended(pid):
    """Wait until a process has ended; return whether it has."""
    deadline = time.monotonic() + TIMEOUT_S
    while not gone(pid) and time.monotonic() < deadline:
        time.sleep(0.01)
    return gone(pid)


@pytest.mark.skipif(sys.platform != 'linux', reason='the kernel ends the process there')
def test_a_command_that_is_killed_leaves_no_process(start, tmp_path):
    law = tmp_path / 'law.py'
    law.write_text('def control(i, n, p, t):\n    print("here")\n    sum(iter(int, 1))\n')
    command = start(*SETCMAS, 'offline', '--algo', str(law), '--call-timeout', '600')
    command.wait_for_output('here')
    children = psutil.Process(command.pid).children(recursive=True)

    command.popen.kill()

    assert children
    assert all(ended(child.pid) for child in children)


def test_mistakes_are_those_of_the_user(run):
    with pytest.raises(SetcmasError, match=r'law\.py, line 4: ZeroDivisionError'):
        run(top='1 / 0')
