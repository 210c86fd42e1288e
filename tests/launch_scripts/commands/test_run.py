import csv
import os
import signal
import time

import numpy as np
import psutil
import pytest
import yaml
from processes import SETCMAS, TIMEOUT_S, run_here, run_setcmas

pytest.importorskip('rclpy')

DELAYED = "import sys, time\nif any('{}' in text for text in sys.orig_argv):\n    time.sleep({})\n"
RUN = (*SETCMAS, 'run', '--no-plots', '--output', 'out')


def table(path):
    with path.open() as file:
        rows = csv.DictReader(file)
        return [{k: float(v) for k, v in row.items() if k != 'header.frame_id'} for row in rows]


def nodes_of(process):
    return [child.pid for child in psutil.Process(process.pid).children(recursive=True)]


def all_gone(pids):
    there = [psutil.Process(pid) for pid in pids if psutil.pid_exists(pid)]
    return psutil.wait_procs(there, TIMEOUT_S)[1] == []


@pytest.mark.nightly
def test_the_whole_job_misses_nothing_though_its_recorder_is_slow_to_start(start, tmp_path):
    (tmp_path / 'sitecustomize.py').write_text(DELAYED.format('setcmas_tools.bags.recorder', 2))
    process = start(
        *SETCMAS, 'run', '--algo', 'consensus', '--nb-robots', '3', '--duration', '8',
        '--pose', '1:1,0', '--pose', '2:0,1', '--pose', '3:-1,-1', '--output', 'out',
        '--format', 'svg', cwd=tmp_path, env={'PYTHONPATH': str(tmp_path)},
    )  # fmt: skip
    process.wait_for_output('[ctrl] controlling robots 1-3')
    nodes = nodes_of(process)

    assert process.wait() == 0, process.output()
    assert len(nodes) == 3
    assert all_gone(nodes)
    out = tmp_path / 'out'
    assert (out / 'bag' / 'metadata.yaml').is_file()
    assert {path.suffix for path in (out / 'plots').iterdir()} == {'.svg'}
    fleet = table(out / 'csv' / 'fleet.csv')
    assert list(fleet[0]) == ['t', 'robot', 'x', 'y', 'theta', 'v', 'omega']
    first = {row['robot']: (row['x'], row['y'], row['theta']) for row in reversed(fleet)}
    assert first == {1: (1, 0, 0), 2: (0, 1, 0), 3: (-1, -1, 0)}
    assert fleet[-1]['t'] > 6
    last = np.array([[row['x'], row['y']] for row in fleet[-3:]])
    assert np.ptp(last, axis=0).max() < 0.3
    assert {row['robot'] for row in fleet[-3:]} == {1, 2, 3}
    commands = table(out / 'csv' / 'tb3_2_cmd_vel.csv')
    assert commands[-1]['twist.linear.x'] == 0.0
    record = yaml.safe_load((out / 'run.yaml').read_text())
    assert record['outcome'] == {'state': 'complete'}
    assert yaml.safe_load((out / 'csv' / 'task.json').read_text())['task'] == 'consensus'
    assert record['scenario']['nb_robots'] == 3
    assert 'def control' in (out / record['scenario']['algo']).read_text()
    assert 'The robots met: at most ' in process.output()


def test_an_interrupted_run_keeps_what_it_has(start, tmp_path):
    law = 'def control(i, n, poses, t):\n    return 0.1, 0.1 / (i - 2)\n'
    (tmp_path / 'law.py').write_text(law)
    process = start(*RUN, '--algo', 'law.py', '--nb-robots', '2', cwd=tmp_path)
    process.wait_for_output('ZeroDivisionError')
    nodes = nodes_of(process)
    bag = tmp_path / 'out' / 'bag' / 'bag.mcap'
    wait_for_growth(bag)

    assert process.end(signal.SIGINT) == 130
    assert all_gone(nodes)
    assert table(tmp_path / 'out' / 'csv' / 'fleet.csv')
    record = yaml.safe_load((tmp_path / 'out' / 'run.yaml').read_text())
    assert record['outcome'] == {'state': 'stopped'}
    assert [(one['robot'], one['line']) for one in record['failures']] == [(2, 2)]


def wait_for_growth(path):
    deadline = time.monotonic() + TIMEOUT_S
    while not path.exists() or path.stat().st_size < 4096:
        assert time.monotonic() < deadline
        time.sleep(0.05)


def test_when_a_process_dies_the_launcher_says_so_and_stops_the_rest(start, tmp_path):
    process = start(*RUN, '--algo', 'consensus', '--nb-robots', '2', cwd=tmp_path)
    process.wait_for_output('[ctrl] controlling')
    nodes = nodes_of(process)
    dying = [pid for pid in nodes if 'controller' in ' '.join(psutil.Process(pid).cmdline())]
    os.kill(dying[0], signal.SIGKILL)

    assert process.wait() not in (0, 2)
    assert all_gone(nodes)
    assert f'(process {dying[0]}) was killed by SIGKILL' in process.output()
    record = yaml.safe_load((tmp_path / 'out' / 'run.yaml').read_text())
    assert record['outcome']['state'] == 'died'
    assert 'SIGKILL' in record['outcome']['detail']
    assert 'Traceback' not in process.output()


def test_a_script_with_a_mistake_starts_nothing(domain, tmp_path):
    (tmp_path / 'law.py').write_text('def control(a, b, c, d):\n    return 1,, 2\n')

    result = run_here(*RUN[1:], '--algo', 'law', cwd=tmp_path)

    assert result.returncode == 2
    assert 'law.py, line 2: SyntaxError' in result.stderr
    assert 'return 1,, 2' in result.stderr
    assert not (tmp_path / 'out').exists()


def test_files_of_the_user_do_not_hide_those_of_python(start, tmp_path):
    for name in ('random', 'numpy', 'queue', 'rclpy'):
        (tmp_path / f'{name}.py').write_text('raise RuntimeError("hidden")\n')

    process = start(*SETCMAS, 'simu', '--nb-robots', '1', cwd=tmp_path)

    process.wait_for_output('simulating robot 1')


def test_three_terminals(start, tmp_path):
    simu = start(*SETCMAS, 'simu', '--nb-robots', '2', cwd=tmp_path)
    simu.wait_for_output('simulating robots 1-2')
    record = start(*SETCMAS, 'record', '-o', 'bag', cwd=tmp_path)
    record.wait_for_output('recording')
    ctrl = start(*SETCMAS, 'ctrl', '--algo', 'consensus', cwd=tmp_path)
    ctrl.wait_for_output('controlling robots 1-2')
    wait_for_growth(tmp_path / 'bag' / 'bag.mcap')
    for process in (ctrl, record, simu):
        assert process.end(signal.SIGINT) == 0, process.output()
        assert 'Traceback' not in process.output()

    assert run_here('bag_to_csv', 'bag', cwd=tmp_path).returncode == 0
    assert table(tmp_path / 'csv' / 'fleet.csv')


def test_a_run_that_is_stopped_before_the_robots_start_leaves_no_folder(start, tmp_path):
    (tmp_path / 'sitecustomize.py').write_text(DELAYED.format('setcmas_ctrl.controllers', 60))
    env = {'PYTHONPATH': str(tmp_path)}
    process = start(*RUN, '--algo', 'consensus', cwd=tmp_path, env=env)
    process.wait_for_output('[simu] simulating')
    assert (tmp_path / 'out' / 'run.yaml').exists()

    assert process.end(signal.SIGINT) == 130
    assert not (tmp_path / 'out').exists()


@pytest.mark.nightly
def test_when_a_law_failed_is_kept_over_ros_as_offline(tmp_path, domain):
    law = 'def control(i, n, poses, t):\n    return 1 / (i < 2 or not 0.5 < t < 1.3), 0.0\n'
    (tmp_path / 'law.py').write_text(law)
    given = ('--algo', 'law.py', '--nb-robots', '2', '--duration', '2', '--no-plots')
    run_setcmas('run', *given, '-o', 'ros', cwd=tmp_path)
    run_here('offline', *given, '-o', 'offline', cwd=tmp_path)
    (ros,), (offline,) = (
        yaml.safe_load((tmp_path / name / 'run.yaml').read_text())['failures']
        for name in ('ros', 'offline')
    )

    called = {'t', 'until'}  # at these times, which in real time are only about the same
    assert {key: ros[key] for key in ros.keys() - called} == {
        key: offline[key] for key in offline.keys() - called
    }
    assert (offline['t'], offline['until'], ros['robot'], ros['line']) == (0.6, 1.4, 2, 2)
    assert 0.5 < ros['t'] < 1.3 <= ros['until']
