"""Scripts with a mistake each: what the student reads, offline and from real nodes.

The scripts are in bad; comments at their top name texts of the output: `load` while
the script is loaded (the controller ends with status 2), `run` while the robots run.
"""

import re
import signal
from pathlib import Path

import pytest
from processes import CTRL, SIMU

from setcmas_simu.errors import SetcmasError
from setcmas_tools import simulate

pytest.importorskip('rclpy')


BAD = Path(__file__).parent / 'bad'
SCRIPTS = sorted(path for path in BAD.glob('*.py') if not path.name.startswith('_'))


def expected(path, when):
    text = path.read_bytes().decode(errors='replace')
    return re.findall(rf'^# {when}: (.*)$', text, re.MULTILINE)


LOADING = [path for path in SCRIPTS if expected(path, 'load')]
RUNNING = [path for path in SCRIPTS if expected(path, 'run')]
IN_A_CONTROLLER = [
    BAD / f'{name}.py' for name in ('endless_loop', 'endless_while_loading', 'keyboard_interrupt')
]
"""Scripts whose mistakes only a controller process can report: calls that last, and Ctrl-C."""


def test_every_script_says_what_to_expect():
    assert sorted(LOADING + RUNNING) == SCRIPTS
    assert len(SCRIPTS) >= 20
    assert {*IN_A_CONTROLLER} <= set(RUNNING)


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


def test_a_mistake_that_is_found_while_a_controller_loads(start):
    process = start(*CTRL, '--algo', str(BAD / 'no_control.py'), '--nb-robots', '1')

    assert process.wait() == 2
    assert process.output().startswith('error: no_control.py has no function control; ')
    assert 'Traceback' not in process.output()


def test_mistakes_that_are_found_while_a_controller_runs(start):
    paths = [*IN_A_CONTROLLER, BAD / 'returns_none.py']
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
