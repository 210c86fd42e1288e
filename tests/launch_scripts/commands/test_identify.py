from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
from processes import PATIENT_LAB, refuses, run_here

from launch_scripts.cli import main
from setcmas_simu.robots.identified_robot import read_model_file
from setcmas_tools import simulate
from setcmas_tools.compare.run_distance import best_shift
from setcmas_tools.run.run import Run

TRUTH = """limits: burger
robots:
  1:
    forward: {gain: 0.95, lag: 0.15, delay: 0.25}
    turn: {gain: 0.9, lag: 0.1, delay: 0.25}
  2:
    forward: {gain: 1.0, lag: 0.3, delay: 0.15}
    turn: {gain: 1.05, lag: 0.2, delay: 0.15}
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'truth.yaml').write_text(TRUTH)
    return tmp_path


def assert_found(found, names=('gain', 'lag', 'delay')):
    """Each gain, lag and delay is within a tenth of the truth."""
    truth, model = read_model_file(Path('truth.yaml')), read_model_file(Path(found))
    for robot, true in truth.robots.items():
        for name in ('forward', 'turn'):
            own, known = (asdict(getattr(one, name)) for one in (model.robots[robot], true))
            for one in names:
                assert own[one] == pytest.approx(known[one], rel=0.1), (robot, name, one)


def noisy(run):
    """The run as motion capture would have seen it."""
    rng, table = np.random.default_rng(3), run.table
    wrong = {
        name: getattr(table, name) + rng.normal(0.0, sigma, len(table.t))
        for name, sigma in (('x', 2e-4), ('y', 2e-4), ('theta', 2e-3))
    }
    return replace(run, tables=replace(run.tables, fleet=replace(table, **wrong)))


def test_the_next_simulation_is_nearer_to_what_was_measured(folder, capsys):
    run = noisy(simulate('nav_wp', 2, 60.0, model='truth.yaml', robot_rate=50.0))
    run.save('seen')

    assert main(['identify', 'seen', '-o', 'found.yaml']) == 0

    assert_found('found.yaml')
    printed = capsys.readouterr().out.split()
    assert printed[-1] == 'found.yaml'
    nearer = simulate('nav_wp', 2, 60.0, model='found.yaml')
    before = simulate('nav_wp', 2, 60.0, limits='burger')
    near, far = (max(best_shift(run, one).rms.values()) for one in (nearer, before))
    assert near < 0.2 * far


@pytest.mark.nightly
def test_a_run_over_ros_moves_by_the_model_and_announces_it(folder, domain):
    # Too slow for limits: then the recorded commands are those that robots follow.
    slow = ('--vnom', '0.1', '--komega', '0.5', '--set', 'WPL=[[4.8, 4.9], [4.9, -4.8]]')
    options = ('--model', 'truth.yaml', '--nb-robots', '2', '--duration', '20', *slow)
    ran = run_here('run', '--algo', 'nav_wp', *options, '--no-plots', '-o', 'out')
    assert ran.returncode == 0, ran.stderr

    assert main(['identify', 'out/bag', '-o', 'found.yaml']) == 0

    # Not lag and delay: a command takes effect with the robots' next step, up to 0.1 s later.
    assert_found('found.yaml', ['gain'])
    assert run_here('offline', '--from', 'out', '--no-plots', '-o', 'off').returncode == 0
    apart = best_shift(Run.load('off'), Run.load('out'))
    assert max(apart.rms.values()) < 0.1 * 0.1  # that time at 0.1 m/s


@pytest.mark.nightly
@pytest.mark.alone
def test_lag_and_delay_of_the_emulated_lab_are_found(folder, domain):
    lab = (*PATIENT_LAB, '--model', 'truth.yaml', '--nb-robots', '2', '--without-motion-check')
    ran = run_here('expe', '--algo', 'nav_wp', *lab, '--duration', '30', '--no-plots', '-o', 'lab')
    assert ran.returncode == 0, ran.stderr

    assert main(['identify', 'lab', '-o', 'found.yaml']) == 0

    assert_found('found.yaml')
    for name, options in (('near', ['--model', 'found.yaml']), ('far', ['--model', 'burger'])):
        assert main(['offline', '--from', 'lab', *options, '--no-plots', '-o', name]) == 0
    lab = Run.load('lab')
    near, far = (max(best_shift(lab, Run.load(name)).rms.values()) for name in ('near', 'far'))
    assert near < 0.5 * far


def test_a_run_without_motion_gives_no_model(folder, capsys):
    (folder / 'stands.py').write_text(
        'def control(robotNo, nbRobots, poses, t):\n    return 0, 0\n'
    )
    simulate('stands.py', 1, 10.0).save('still')

    assert main(['identify', 'still']) == 1

    assert 'tb3_1: its commands change too little to identify' in capsys.readouterr().err
    assert not (folder / 'model.yaml').exists()


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (['seen', '-o', 'model.csv'], "--output is 'model.csv'; it must end in .yaml or .yml"),
        (['seen', '-o', 'truth.yaml'], "'truth.yaml' already exists; choose another name"),
        (['nowhere'], "'nowhere'"),
        (['seen/csv/fleet.csv'], 'has no commands of robots'),
    ],
)
def test_a_mistake_is_reported_in_one_line(folder, arguments, message):
    simulate('nav_wp', 1, 3.0).save('seen')
    (folder / 'seen' / 'csv' / 'commands.csv').unlink()

    refuses('identify', *arguments, message=message, cwd=folder)
