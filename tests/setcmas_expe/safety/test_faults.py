"""Robots stop whatever breaks, before they have rolled far.

tests/benchmarks/faults.py takes the time.

They go at 0.1 m/s here, so that a busy machine has twice the time for the same way.
"""

import pytest

pytest.importorskip('rclpy')

from rehearsal import BRIDGES, Rehearsal

WAY = 0.16  # m
SLOW = ('--vnom', '0.1')
GOES = 0.07  # m/s: what 0.1 m/s is, cut to hundredths, and a little less in curves


@pytest.fixture
def experiment(peer, tmp_path):
    with Rehearsal(peer, tmp_path, *SLOW) as running:
        running.let_go(GOES)
        yield running


def test_motion_capture_and_scripts_fail_one_after_the_other(experiment):
    for kind in ('dropout', 'zero', 'nan', 'frozen', 'jump'):
        stop = experiment.wait_for_stop(experiment.fault(f'{kind} 1 1.2'))
        assert stop.metres < WAY, kind
        assert experiment.truth[2][-1].V > GOES, f'{kind} of the other robot'
        experiment.wait_until_all_go(GOES)

    fault = experiment.fault('swap 1 1.2')
    assert max(experiment.wait_for_stop(fault, robot).metres for robot in (1, 2)) < WAY
    experiment.wait_until_all_go(GOES)

    fault = experiment.set_mode('nan')
    assert max(experiment.wait_for_stop(fault, robot).metres for robot in (1, 2)) < WAY
    experiment.set_mode('')
    experiment.wait_until_all_go(GOES)

    fault = experiment.set_mode('stuck')
    assert max(experiment.wait_for_stop(fault, robot).metres for robot in (1, 2)) < WAY


def test_the_bridge_is_killed(experiment):
    fault = experiment.kill(BRIDGES)

    assert max(experiment.wait_for_stop(fault, robot).metres for robot in (1, 2)) < WAY
    assert experiment.process.wait(20) != 0
    assert 'bridge' in experiment.output()


def test_the_terminal_is_closed(experiment):
    fault = experiment.close_terminal()

    assert max(experiment.wait_for_stop(fault, robot).metres for robot in (1, 2)) < WAY
    experiment.process.wait(20)
