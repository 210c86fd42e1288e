"""`setcmas expe` as its user sees it: keys, status lines, and a terminal that is given back."""

import os
import signal
import termios

import psutil
import pytest
import yaml
from processes import PATIENT_LAB, SETCMAS, TIMEOUT_S, refuses, run_here
from terminals import Terminal

from setcmas_tools.run.run_tables import read_fleet

pytest.importorskip('rclpy')

ALGO = (*PATIENT_LAB, '--algo', 'nav_wp', '--no-joystick')


@pytest.fixture
def terminal(domain):
    opened = Terminal('expe', *ALGO, '--nb-robots', '2')
    yield opened
    opened.close()


def ends(terminal, children, status):
    assert terminal.wait() == status
    assert termios.tcgetattr(terminal.slave) == terminal.before
    assert psutil.wait_procs(children, TIMEOUT_S)[1] == []


def test_keys_start_pause_stop_and_give_the_terminal_back(terminal):
    terminal.wait_for('paused; s starts the robots')
    terminal.wait_for(r'PAUSED.*?tb3_1 +0\.\d\d s +\d+ % +0\.0\d m/s +paused +paused\s')
    children = psutil.Process(terminal.process.pid).children()
    assert len(children) == 4
    assert termios.tcgetattr(terminal.slave) != terminal.before

    terminal.start_robots(r'RUNNING.*?tb3_2 +0\.\d\d s +\d+ % +0\.[12]\d m/s +moving')
    terminal.text = ''  # a stall of this machine may pause them before
    terminal.press('\x1b[A\x1bOP')  # an arrow and F1 begin as Esc does
    terminal.press(' ')
    terminal.wait_for('PAUSED')
    terminal.press('\x1b')
    terminal.wait_for('STOP HELD.*by Esc.*R twice: release it')
    terminal.press_until('not started: stop by Esc; R twice releases it', 's')
    terminal.press('RR')
    terminal.wait_for('the second R came too soon')
    released = 'R again after 1 to 3 s to release it.*paused: the stop is released.*PAUSED'
    terminal.press_until(released, 'R')
    terminal.press('q')

    ends(terminal, children, 0)
    assert 'Traceback' not in terminal.text


@pytest.mark.nightly
def test_when_a_process_dies_everything_stops(terminal):
    terminal.wait_for('PAUSED')
    children = psutil.Process(terminal.process.pid).children()
    dying = next(child for child in children if 'bridges' in ' '.join(child.cmdline()))
    terminal.text = ''
    dying.kill()

    ends(terminal, children, 128 + signal.SIGKILL)
    assert f'(process {dying.pid}) was killed by SIGKILL' in terminal.read()


@pytest.mark.nightly
def test_without_its_joystick_an_experiment_ends_because_another_could_start_its_robots(
    domain, tmp_path, monkeypatch
):
    node = tmp_path / 'lib' / 'joy' / 'joy_node'
    node.parent.mkdir(parents=True)
    node.write_text('#!/bin/sh\nexec sleep 600\n')
    node.chmod(0o755)
    prefixes = os.pathsep.join([str(tmp_path), os.environ.get('AMENT_PREFIX_PATH', '')])
    monkeypatch.setenv('AMENT_PREFIX_PATH', prefixes.rstrip(os.pathsep))
    terminal = Terminal('expe', *PATIENT_LAB, '--algo', 'nav_wp', '--nb-robots', '1')
    try:
        terminal.wait_for('button 7 of the joystick.*PAUSED')
        children = psutil.Process(terminal.process.pid).children()
        next(child for child in children if 'sleep' in child.cmdline()).kill()
        ends(terminal, children, 128 + signal.SIGKILL)
        assert 'joystick (process' in terminal.read()
    finally:
        terminal.close()


@pytest.mark.nightly
def test_with_a_duration_it_starts_records_and_ends_by_itself(start, tmp_path):
    process = start(
        *SETCMAS, 'expe', *PATIENT_LAB, '--algo', 'consensus', '--nb-robots', '2',
        '--duration', '4', '--without-motion-check', '--no-plots', '--output', 'out', cwd=tmp_path,
    )  # fmt: skip

    assert process.wait() == 0, process.output()
    fleet = read_fleet(tmp_path / 'out' / 'csv' / 'fleet.csv')
    assert fleet.robots == [1, 2]
    for robot in fleet.robots:
        motion = fleet.of(robot)
        places = motion.x + 1j * motion.y
        assert abs(places[0]) > 1.0  # by motion capture: the wheels count from 0
        ways = abs(places - places[0])
        assert ways[motion.t < 0].max(initial=0.0) < 0.01  # t = 0 is the start
        assert ways[-1] > 0.1
    assert '\x02' not in process.output()
    recorded = yaml.safe_load((tmp_path / 'out' / 'run.yaml').read_text())
    assert recorded['scenario']['arena'] == [-3, 3, -3, 3]
    assert recorded['lab']['limits']['V_max'] == pytest.approx(0.2108)
    assert recorded['outcome'] == {'state': 'complete'}
    measured = run_here('metrics', 'out', cwd=tmp_path)
    assert 'safety: ' in measured.stdout


@pytest.mark.nightly
def test_a_recording_that_is_stopped_keeps_its_bag(domain, tmp_path):
    terminal = Terminal('expe', *ALGO, '--duration', '600', '--no-plots', '-o', tmp_path / 'out')
    terminal.wait_for('started: by command.*running: ')
    terminal.press('q')

    ends(terminal, [], 130)
    terminal.close()
    outcome = yaml.safe_load((tmp_path / 'out' / 'run.yaml').read_text())['outcome']
    assert outcome == {'state': 'stopped'}
    assert read_fleet(tmp_path / 'out' / 'csv' / 'fleet.csv').robots == [1]


@pytest.mark.nightly
def test_without_a_terminal_the_status_is_a_line_now_and_then(start):
    process = start(*SETCMAS, 'expe', *PATIENT_LAB, '--algo', 'nav_wp')
    process.wait_for_output('no terminal to read keys from')
    process.wait_for_output('PAUSED; tb3_1 paused\n')

    assert process.end(signal.SIGTERM) == 0
    assert '\x1b' not in process.output()
    assert '\x02' not in process.output()


def test_start_poses_that_wheels_cannot_measure_are_confirmed(domain, tmp_path):
    lab = tmp_path / 'lab.yaml'
    robots = 'robots:\n  - {number: 1, start: [1.0, -0.5, 1.5708]}\n'
    lab.write_text(f'mocap: {{preset: wheel_odometry}}\n{robots}')
    terminal = Terminal('expe', '--algo', 'nav_wp', '--no-joystick', '--lab', str(lab))
    try:
        terminal.wait_for(r'tb3_1 at \(1, -0.5\) m, heading 90 deg; press y once every robot')
        terminal.press_until('paused; s starts', 'y')
        terminal.press('q')
        assert terminal.wait() == 0
    finally:
        terminal.close()


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (('--lab', 'none.yaml'), "'none.yaml' cannot be read"),
        (('--lab', 'bad.yaml'), "bad.yaml, line 2: there is no key 'arena.z'"),
        (
            ('--arena=-3000,3000,-3,3',),
            'arena is -3000, 3000, -3, 3; it must be in m, within 100 m',
        ),
        (
            ('--arena=0,0.1,0,1', '--min-separation', '0.2'),
            'the arena is 0.1 m by 1 m; it must be',
        ),
        (('--obstacles', 'disc 0 900 300'), 'obstacle disc is 0, 900, 300; it must be in m'),
        (('--lab', 'number.yaml'), "it must be a text; put it in quotes: '1'"),
        (('--lab', 'far.yaml'), 'the start pose of robot 1, (5, 0) m, is outside the arena'),
        (('--lab', 'wheels.yaml'), 'wheel_odometry needs a person at a terminal, who confirms'),
        (('--pose', '1:0,0'), 'add --emulate'),
        (('--no-joystick',), 'no terminal and no joystick: nothing could start the robots'),
        (('--algo', 'external', '--set', 'K=3'), '--set is for control laws; --algo external has'),
        (('--rate', '2'), '--rate is 2; it must be above 2 Hz in this lab'),
        (('--duration', '9'), 'which only emulated robots may do: add --emulate'),
        (('--output', 'out'), 'or record real robots with setcmas record'),
        (('--emulate', '--duration', '0'), '--duration is 0; it must be'),
        (('--emulate', '--hold', '-o', 'out'), '--hold needs a person who holds s'),
        (('--emulate', '-o', 'bad.yaml'), "output 'bad.yaml' is not a folder"),
    ],
)
def test_mistakes_are_reported_before_anything_starts(arguments, message, tmp_path):
    (tmp_path / 'bad.yaml').write_text('arena:\n  z: 1\n')
    (tmp_path / 'number.yaml').write_text('robots:\n  - {number: 1, mocap_name: 1}\n')
    for name, x in (('far', 5), ('wheels', 1)):
        (tmp_path / f'{name}.yaml').write_text(
            f'mocap:\n  preset: wheel_odometry\nrobots:\n  - {{number: 1, start: [{x}, 0, 0]}}\n'
        )
    refuses('expe', '--algo', 'nav_wp', *arguments, message=message, cwd=tmp_path)


def test_a_lab_file_of_ones_own_is_written_once(tmp_path):
    result = run_here('new', '--lab', cwd=tmp_path)

    assert result.returncode == 0
    assert 'setcmas expe --emulate --lab lab.yaml' in result.stdout
    assert (tmp_path / 'lab.yaml').read_text().startswith('# A lab:')
    assert run_here('new', '--lab', 'lab', cwd=tmp_path).returncode == 2
    assert run_here('new', '--lab', 'b106.yaml', cwd=tmp_path).returncode == 0
    assert run_here('new', cwd=tmp_path).returncode == 2
