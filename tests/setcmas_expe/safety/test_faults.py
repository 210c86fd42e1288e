"""Robots stop whatever breaks, before they have rolled far.

benchmarks/faults.py takes the time.

They go at 0.1 m/s here, so that a busy machine has twice the time for the same way.
"""

import pytest
from processes import TIMEOUT_S

pytest.importorskip('rclpy')

from rehearsal import BRIDGES, Rehearsal

WAY = 0.16  # m
SLOW = ('--vnom', '0.1', '--resume')
GOES = 0.07  # m/s: what 0.1 m/s is, cut to hundredths, and a little less in curves


@pytest.fixture
def checked(peer, tmp_path):
    with Rehearsal(peer, tmp_path, *SLOW) as running:
        running.let_go(GOES)
        yield running


@pytest.fixture
def experiment(peer, tmp_path):
    """Run an experiment whose robots need no time to prove who they are."""
    with Rehearsal(peer, tmp_path, *SLOW, '--without-motion-check') as running:
        running.let_go(GOES)
        yield running


def test_motion_capture_and_scripts_fail_one_after_the_other(checked):
    for kind in ('dropout', 'zero', 'nan', 'frozen', 'jump'):
        stop = checked.wait_for_stop(checked.fault(f'{kind} 1 1.2'))
        assert stop.metres < WAY, kind
        assert checked.truth[2][-1].V > GOES, f'{kind} of the other robot'
        checked.wait_until_all_go(GOES)

    fault = checked.fault('swap 1 1.2')
    assert max(checked.wait_for_stop(fault, robot).metres for robot in (1, 2)) < WAY
    checked.wait_until_all_go(GOES)

    fault = checked.set_mode('nan')
    assert max(checked.wait_for_stop(fault, robot).metres for robot in (1, 2)) < WAY
    checked.set_mode('')
    checked.wait_until_all_go(GOES)

    assert checked.wait_for_stop(checked.fault('fallen 1 60')).metres < WAY
    fault = checked.set_mode('stuck')
    assert max(checked.wait_for_stop(fault, robot).metres for robot in (1, 2)) < WAY


def test_the_bridge_is_killed(experiment):
    fault = experiment.kill(BRIDGES)

    assert max(experiment.wait_for_stop(fault, robot).metres for robot in (1, 2)) < WAY
    assert experiment.process.wait(TIMEOUT_S) != 0
    assert 'bridge' in experiment.output()


def test_the_terminal_is_closed(experiment):
    fault = experiment.close_terminal()

    assert max(experiment.wait_for_stop(fault, robot).metres for robot in (1, 2)) < WAY
    experiment.process.wait(TIMEOUT_S)
