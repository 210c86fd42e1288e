"""Scripts with a mistake each: what the student reads, offline and from real nodes.

The scripts are in bad; comments at their top name texts of the output: `load` while
the script is loaded (the controller ends with status 2), `run` while the robots run.
"""

import re
import signal
from pathlib import Path

import pytest
from processes import CTRL, SETCMAS, SIMU

from setcmas_simu.errors import SetcmasError
from setcmas_tools import simulate

pytest.importorskip('rclpy')

from ros_peer import velocity

BAD = Path(__file__).parent / 'bad'
SCRIPTS = sorted(path for path in BAD.glob('*.py') if not path.name.startswith('_'))


def expected(path, when):
    text = path.read_bytes().decode(errors='replace')
    return re.findall(rf'^# {when}: (.*)$', text, re.MULTILINE)


LOADING = [path for path in SCRIPTS if expected(path, 'load')]
RUNNING = [path for path in SCRIPTS if expected(path, 'run')]
IN_A_CONTROLLER = [
    BAD / f'{name}.py'
    for name in ('endless_loop', 'endless_while_loading', 'keyboard_interrupt', 'sleeps', 'slow')
]
"""Scripts whose mistakes only a controller process can report: calls that last, and Ctrl-C."""

# A few of the others over ROS too: what they say is found by the same code, in another process.
LOADING_OVER_ROS = [
    BAD / f'{name}.py' for name in ('syntax_error', 'exits_while_loading', 'no_control')
]
RUNNING_OVER_ROS = [BAD / f'{name}.py' for name in ('exits', 'fails_for_a_while', 'returns_none')]


def test_every_script_says_what_to_expect():
    assert sorted(LOADING + RUNNING) == SCRIPTS
    assert len(SCRIPTS) >= 20
    assert {*IN_A_CONTROLLER, *RUNNING_OVER_ROS} <= set(RUNNING)
    assert set(LOADING_OVER_ROS) <= set(LOADING)


@pytest.mark.parametrize('path', LOADING, ids=lambda path: path.stem)
def test_mistakes_that_are_found_while_loading(path):
    with pytest.raises(SetcmasError) as error:
        simulate(path)

    for text in expected(path, 'load'):
        assert text in str(error.value)
    assert 'Traceback' not in str(error.value)


@pytest.mark.parametrize(
    'path', sorted(set(RUNNING) - set(IN_A_CONTROLLER)), ids=lambda path: path.stem
)
def test_mistakes_that_are_found_while_running(path):
    said = []
    simulate(path, nb_robots=2, duration=5, warn=said.append)

    output = '\n'.join(said)
    for text in expected(path, 'run'):
        assert text in output
    assert 'tb3_1' in output
    assert 'Traceback' not in output
    assert output.count(expected(path, 'run')[0]) == 1  # repeated errors are counted


def test_mistakes_that_are_found_while_a_controller_loads(start):
    processes = [start(*CTRL, '--algo', str(p), '--nb-robots', '1') for p in LOADING_OVER_ROS]
    for path, process in zip(LOADING_OVER_ROS, processes, strict=True):
        assert process.wait() == 2, path.name
        for text in expected(path, 'load'):
            assert text in process.output()
        assert process.output().startswith('error: ')
        assert 'Traceback' not in process.output()


def test_mistakes_that_are_found_while_a_controller_runs(start):
    paths = IN_A_CONTROLLER + RUNNING_OVER_ROS
    fleet = str(len(paths))
    start(*SIMU, '--nb-robots', fleet).wait_for_output('simulating')
    processes = [
        start(*CTRL, '--algo', str(path), '--nb-robots', fleet, '--robots', str(robot))
        for robot, path in enumerate(paths, start=1)
    ]
    for robot, (path, process) in enumerate(zip(paths, processes, strict=True), start=1):
        for text in expected(path, 'run'):
            process.wait_for_output(text)
        output = process.output()
        assert f'tb3_{robot}' in output
        assert 'Traceback' not in output
        assert output.count(expected(path, 'run')[0]) == 1  # repeated errors are counted
    for process in processes:
        process.popen.send_signal(signal.SIGINT)
    assert {process.wait() for process in processes} <= {0, 1}


def test_a_script_that_takes_all_memory_stops_its_own_robot_only(start, peer, script):
    law = script(
        """
        import resource
        import numpy as np
        used = int(open('/proc/self/statm').read().split()[0]) * resource.getpagesize()
        limit = used + 2**30  # so that the machine of the test survives
        resource.setrlimit(resource.RLIMIT_AS, (limit, resource.RLIM_INFINITY))
        def control(robotNo, nbRobots, poses, t):
            taken = []
            while robotNo == 1:
                taken.append(np.empty(2**27, np.uint8))
            return 0.2, 0
        """
    )
    start(*SIMU, '--nb-robots', '2')
    command = peer.cmd_vel(2)
    process = start(*CTRL, '--algo', law, '--nb-robots', '2')

    peer.wait_for(lambda: len(command) > 5 and velocity(command[-1])[0] > 0.1)
    assert 'law.py, line 10: ' in process.wait_for_output('MemoryError')
    assert process.end() == 1


def test_ctrl_c_ends_a_script_that_never_finishes_loading(start, script):
    law = script('while True:\n    pass\ndef control(i, n, p, t):\n    return 0, 0\n')
    process = start(*SETCMAS, 'ctrl', '--algo', law, '--nb-robots', '1')
    process.wait_for_output('has been loading for 2 s')

    assert process.end() == 0
    assert 'Traceback' not in process.output()
