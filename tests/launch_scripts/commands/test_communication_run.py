"""Event-triggered runs, with a participant of its own that counts messages."""

import contextlib
import csv
import subprocess

import numpy as np
import pytest
import yaml
from processes import SETCMAS, TIMEOUT_S, run_setcmas
from ros_domain import reserved_domain

pytest.importorskip('rclpy')

from nav_msgs.msg import Odometry
from ros_peer import Peer
from std_msgs.msg import UInt16

from setcmas_tools.run.run_tables import read_communication, read_fleet


@pytest.mark.nightly
def test_the_run_of_the_paper(tmp_path):
    """The run of the paper's figures 3 and 4."""
    robots, duration = range(1, 9), 45
    out, output, heard = run(robots, duration, tmp_path)
    record = read_communication(out / 'csv')

    assert 0.03 < record.triggers[:, 2].mean() < 0.09
    assert all(12 <= counts.sent <= 40 for counts in record.robots.values())
    robots_meet(robots, out)
    what_is_told_is_what_happened(robots, duration, out, output, heard, tmp_path)


def test_a_short_run(domain, tmp_path):
    robots, duration = range(1, 4), 8
    options = [*fleet_options(robots, duration), '--lockstep', '--output', 'out']
    result = run_setcmas('run', '--algo', 'consensus', *options, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    record = read_communication(tmp_path / 'out' / 'csv')
    share = record.triggers[:, 2].mean()

    assert f'({100 * share:.1f} % of' in result.stdout
    assert len(record.triggers) == len(robots) * (duration * 10 + 1)
    every_message_arrives(robots, record)
    files_tell_of_it(robots, share, tmp_path / 'out', result.stdout)


def what_is_told_is_what_happened(robots, duration, out, output, heard, folder):
    record = read_communication(out / 'csv')
    share = record.triggers[:, 2].mean()

    assert f'({100 * share:.1f} % of' in output
    assert len(record.triggers) == pytest.approx(len(robots) * duration * 10, rel=0.15)
    traffic_falls_by_the_ratio_of_triggers(robots, record, heard)
    every_message_arrives(robots, record)
    files_tell_of_it(robots, share, out, output)
    an_offline_run_agrees(robots, duration, record, folder)


def run(robots, duration, folder):
    """Return the folder of the run, what was printed, and the messages that a peer heard."""
    with contextlib.ExitStack() as stack:
        domain = stack.enter_context(reserved_domain())
        patch = stack.enter_context(pytest.MonkeyPatch.context())
        patch.setenv('ROS_DOMAIN_ID', str(domain))
        patch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
        peer = stack.enter_context(Peer(domain))
        kinds = {'odom': Odometry, 'trig_odom': Odometry, 'trig_event': UInt16}
        heard = {
            topic: [peer.listen(kind, f'/tb3_{i}/{topic}', 1000) for i in robots]
            for topic, kind in kinds.items()
        }
        options = [*fleet_options(robots, duration), '--output', 'out']
        with (folder / 'log.txt').open('wb') as log:
            process = subprocess.Popen(
                [*SETCMAS, 'run', '--algo', 'consensus', *options],
                cwd=folder,
                stdout=log,
                stderr=subprocess.STDOUT,
            )
        stack.callback(process.kill)
        peer.wait_for(lambda: process.poll() is not None, 2 * TIMEOUT_S)
    output = (folder / 'log.txt').read_text()
    assert process.returncode == 0, output
    return folder / 'out', output, heard


def fleet_options(robots, duration):
    return ['--nb-robots', str(len(robots)), '--event-triggered', '--duration', str(duration)]


def robots_meet(robots, out):
    table = read_fleet(out / 'csv' / 'fleet.csv')
    end = np.array([[table.of(i).x[-1], table.of(i).y[-1]] for i in robots])

    assert np.hypot(*(end - end.mean(axis=0)).T).max() < 0.6


def traffic_falls_by_the_ratio_of_triggers(robots, record, heard):
    share = record.triggers[:, 2].mean()
    for robot, odometry, states, events in zip(
        robots, heard['odom'], heard['trig_odom'], heard['trig_event'], strict=True
    ):
        # A participant that meets the robot late may miss its first states.
        assert abs(len(states) - record.robots[robot].sent) <= 2
        assert abs(len(states) - sum(event.data for event in events)) <= 2
        # Not as many as odometries: on a busy machine robots stand for seconds, before and after.
        evaluated = (record.triggers[:, 1] == robot).sum()
        assert len(events) == pytest.approx(evaluated, rel=0.15)
        assert len(states) < 2.5 * share * min(len(events), len(odometry))


def every_message_arrives(robots, record):
    assert len(record.links) == len(robots) * (len(robots) - 1)
    for (_, sender), counts in record.links.items():
        assert counts.lost == 0
        assert counts.received == counts.sent
        assert abs(counts.sent - record.robots[sender].sent) <= 2


def files_tell_of_it(robots, share, out, output):
    record = yaml.safe_load((out / 'run.yaml').read_text())

    assert record['parameters']['event_triggered'] is True
    assert record['parameters']['graph'] == 'complete'
    assert record['references'] == {'task': 'consensus', 'values': {}}
    messages = yaml.safe_load((out / 'metrics.yaml').read_text())['messages']
    assert messages['triggered_share'] == pytest.approx(share, abs=1e-3)
    assert set(messages['mean_interval_s']) == set(robots)
    assert 'states sent' in output
    plots = {path.stem for path in (out / 'plots').iterdir()}
    assert {'communication_instants', 'communication_counts', 'graph', 'disagreement'} <= plots
    with (out / 'csv' / 'tb3_1_trig_event.csv').open() as file:
        assert {row['data'] for row in csv.DictReader(file)} <= {'0', '1'}


def an_offline_run_agrees(robots, duration, record, folder):
    options = [*fleet_options(robots, duration), '--no-plots', '--output', 'offline']
    result = run_setcmas('offline', '--algo', 'consensus', *options, cwd=folder)
    offline = read_communication(folder / 'offline' / 'csv')

    assert result.returncode == 0
    for robot in robots:
        assert abs(offline.robots[robot].sent - record.robots[robot].sent) <= 5
