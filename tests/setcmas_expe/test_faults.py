"""Robots stop whatever breaks, before they have rolled far.

benchmarks/faults.py takes the time.

They go at 0.1 m/s here, so that a busy machine has twice the time for the same way.
"""

import shutil
from pathlib import Path

import pytest
from processes import TIMEOUT_S

pytest.importorskip('rclpy')

from diagnostic_msgs.msg import DiagnosticStatus
from network_namespaces import on_a_network
from network_rehearsal import (
    roll_after_the_laptop_is_cut_off,
    way_behind_a_firewall,
    ways_past_a_rogue,
)
from rehearsal import BRIDGES, Rehearsal

WAY = 0.16  # m
STANDS_M = 0.005
SLOW = ('--vnom', '0.1')
GOES = 0.07  # m/s: what 0.1 m/s is, cut to hundredths, and a little less in curves


@pytest.fixture
def experiment(peer, tmp_path):
    """Run an experiment whose robots need no time to prove who they are."""
    with Rehearsal(peer, tmp_path, *SLOW, '--without-motion-check') as running:
        running.let_go(GOES)
        yield running


@pytest.mark.nightly
def test_motion_capture_and_scripts_fail_one_after_the_other(peer, tmp_path):
    def roll(fault):
        return max(running.wait_for_stop(fault, robot).metres for robot in (1, 2))

    with Rehearsal(peer, tmp_path, *SLOW) as running:
        for kind in ('dropout', 'nan', 'frozen', 'jump', 'swap', 'fallen'):
            running.let_go(GOES)
            assert roll(running.fault(f'{kind} 1 1.2')) < WAY, kind
        for mode in ('nan', 'stuck'):
            running.set_mode('')
            running.let_go(GOES)
            assert roll(running.set_mode(mode)) < WAY, mode


@pytest.mark.nightly
def test_the_terminal_is_closed(experiment):
    fault = experiment.close_terminal()

    assert max(experiment.wait_for_stop(fault, robot).metres for robot in (1, 2)) < WAY
    experiment.process.wait(TIMEOUT_S)


@pytest.mark.nightly
def test_no_stop_of_a_deaf_robot_is_weaker_than_the_emergency_stop(peer, experiment):
    def rolls():
        return experiment.truth[1][-1].V > GOES

    experiment.fault('deaf 1 600')
    for stop in (
        lambda: experiment.press(' '),
        lambda: experiment.fault('dropout 2 1'),
        lambda: experiment.press('\x1b'),
    ):
        experiment.press_until(rolls)
        assert experiment.wait_for_stop(stop()).metres < WAY
    assert 'robot 1 does not obey zero commands: its motors are off' in experiment.output()

    peer.wait_for(lambda: 'STOP by Esc' in experiment.output())
    experiment.press_until(lambda: 'the stop is released' in experiment.output(), 'R')
    seen = len(experiment.truth[1])
    peer.spin(1.0)
    assert all(truth.rolls == 0.0 for truth in experiment.truth[1][seen:])

    experiment.press_until(rolls)
    assert experiment.wait_for_stop(experiment.kill(BRIDGES)).metres < WAY


def is_out_of_sight(states):
    """Return whether a robot has not been seen for long enough to be another one."""
    values = {pair.key: pair.value for pair in states[-1].values} if states else {}
    return float(values.get('pose_age') or 0.0) > 1.0


@pytest.mark.nightly
def test_bodies_that_are_exchanged_out_of_sight_crawl_and_are_found(peer, tmp_path):
    states = [peer.listen(DiagnosticStatus, f'/tb3_{robot}/bridge_state') for robot in (1, 2)]
    with Rehearsal(peer, tmp_path, *SLOW) as experiment:
        experiment.let_go(GOES)
        peer.wait_for(lambda: experiment.output().count('identified by motion') == 2)
        experiment.wait_for_stop(experiment.press(' '))
        for robot in (1, 2):
            experiment.fault(f'dropout {robot} 600')
        peer.wait_for(lambda: all(map(is_out_of_sight, states)))
        experiment.fault('swap 1 600')
        for robot in (1, 2):  # seen again from now on
            experiment.fault(f'dropout {robot} 0.1')
        begin = {robot: len(truths) for robot, truths in experiment.truth.items()}
        experiment.press_until(lambda: 'names swapped' in experiment.output())
        since = [truth for robot, at in begin.items() for truth in experiment.truth[robot][at:]]
    assert max(truth.rolls for truth in since) < 0.06  # both crawled


@pytest.mark.nightly
def test_a_person_steps_in_front_of_a_robot_with_a_lidar(peer, tmp_path):
    lab = str(Path(__file__).parents[1] / 'data' / 'lidar_lab.yaml')
    with Rehearsal(peer, tmp_path, '--lab', lab, '--without-motion-check') as experiment:
        experiment.let_go()
        fault = experiment.fault('person 1 3')
        stops = [experiment.wait_for_stop(fault, robot) for robot in (1, 2)]
        peer.wait_for(lambda: 'its lidar sees something' in experiment.output())
        stands = len(experiment.truth[1])
        peer.spin(4.0)  # until the person has gone again, and longer
        assert {truth.rolls for truth in experiment.truth[1][stands:]} == {0.0}
        experiment.let_go()

    assert stops[0].metres < 0.23  # from the front of the robot to the person


@pytest.mark.nightly
def test_robots_over_a_network_whose_plug_is_pulled(domain, tmp_path):
    ways = on_a_network(roll_after_the_laptop_is_cut_off, domain, tmp_path)

    assert len(ways) == 2
    assert max(ways) < WAY


@pytest.mark.nightly
def test_only_the_bridge_moves_a_robot_whose_base_listens_to_its_guard_alone(domain, tmp_path):
    rolled, pressed = on_a_network(ways_past_a_rogue, domain, tmp_path)

    assert rolled < WAY
    assert pressed < STANDS_M


@pytest.mark.nightly
@pytest.mark.skipif(not shutil.which('nft'), reason='no nftables')
def test_a_firewall_keeps_a_rogue_out(domain, tmp_path):
    paused, said = on_a_network(way_behind_a_firewall, domain, tmp_path)

    assert 'STOP by Esc: SWITCH tb3_1 OFF' in said
    assert paused < STANDS_M
