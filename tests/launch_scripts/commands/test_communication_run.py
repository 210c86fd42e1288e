"""The run of the paper's figures 3 and 4, with a participant of its own that counts messages."""

import contextlib
import csv
import subprocess

import numpy as np
import pytest
import yaml
from processes import SETCMAS, run_setcmas
from ros_domain import reserved_domain

pytest.importorskip('rclpy')

from nav_msgs.msg import Odometry
from ros_peer import Peer
from std_msgs.msg import UInt16

from setcmas_tools.records.communication import read_csv
from setcmas_tools.records.fleet_table import read_csv as read_fleet

ROBOTS = range(1, 9)


def test_the_run_of_the_paper(tmp_path):
    # One long test: workers share no fixtures, and the run takes a minute.
    out, output, heard = run_of_8(tmp_path)
    record = read_csv(out / 'csv')

    few_evaluations_trigger(record, output)
    robots_meet(out)
    traffic_falls_by_the_ratio_of_triggers(record, heard)
    every_message_arrives(record)
    files_tell_of_it(out, output)
    an_offline_run_agrees(record, tmp_path)


def run_of_8(folder):
    """Return the folder of the run, what was printed, and the messages that a peer heard."""
    with contextlib.ExitStack() as stack:
        domain = stack.enter_context(reserved_domain())
        patch = stack.enter_context(pytest.MonkeyPatch.context())
        patch.setenv('ROS_DOMAIN_ID', str(domain))
        patch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
        peer = stack.enter_context(Peer(domain))
        kinds = {'odom': Odometry, 'trig_odom': Odometry, 'trig_event': UInt16}
        heard = {
            topic: [peer.listen(kind, f'/tb3_{i}/{topic}', 1000) for i in ROBOTS]
            for topic, kind in kinds.items()
        }
        options = ['--nb-robots', '8', '--event-triggered', '--duration', '45', '--output', 'out']
        with (folder / 'log.txt').open('wb') as log:
            process = subprocess.Popen(
                [*SETCMAS, 'run', '--algo', 'consensus', *options],
                cwd=folder,
                stdout=log,
                stderr=subprocess.STDOUT,
            )
        stack.callback(process.kill)
        peer.wait_for(lambda: process.poll() is not None, timeout=180)
    output = (folder / 'log.txt').read_text()
    assert process.returncode == 0, output
    return folder / 'out', output, heard


def few_evaluations_trigger(record, output):
    share = record.triggers[:, 2].mean()

    assert 0.03 < share < 0.09
    assert len(record.triggers) == pytest.approx(8 * 450, rel=0.1)
    assert all(12 <= counts.sent <= 40 for counts in record.robots.values())
    assert f'({100 * share:.1f} % of' in output


def robots_meet(out):
    table = read_fleet(out / 'csv' / 'fleet.csv')
    end = np.array([[table.of(i).x[-1], table.of(i).y[-1]] for i in ROBOTS])

    assert np.hypot(*(end - end.mean(axis=0)).T).max() < 0.6


def traffic_falls_by_the_ratio_of_triggers(record, heard):
    for robot, odometry, states, events in zip(
        ROBOTS, heard['odom'], heard['trig_odom'], heard['trig_event'], strict=True
    ):
        # A participant that meets the robot late may miss its first states.
        assert abs(len(states) - record.robots[robot].sent) <= 2
        assert abs(len(states) - sum(event.data for event in events)) <= 2
        # Not as many as odometries: on a busy machine robots stand for seconds, before and after.
        evaluated = (record.triggers[:, 1] == robot).sum()
        assert len(events) == pytest.approx(evaluated, rel=0.1)
        assert len(states) < 0.12 * min(len(events), len(odometry))


def every_message_arrives(record):
    assert len(record.links) == 56
    for (_, sender), counts in record.links.items():
        assert counts.lost == 0
        assert counts.received == counts.sent
        assert abs(counts.sent - record.robots[sender].sent) <= 2


def files_tell_of_it(out, output):
    record = yaml.safe_load((out / 'run.yaml').read_text())

    assert record['parameters']['event_triggered'] is True
    assert record['parameters']['graph'] == 'complete'
    assert 0.03 < record['communication']['triggered_share'] < 0.09
    assert set(record['communication']['mean_interval_s']) == set(ROBOTS)
    assert 'states sent' in output
    plots = {path.stem for path in (out / 'plots').iterdir()}
    assert {'communication_instants', 'communication_counts', 'graph', 'disagreement'} <= plots
    with (out / 'csv' / 'tb3_1_trig_event.csv').open() as file:
        assert {row['data'] for row in csv.DictReader(file)} <= {'0', '1'}


def an_offline_run_agrees(record, folder):
    options = ['--nb-robots', '8', '--event-triggered', '--duration', '45', '--output', 'offline']
    result = run_setcmas('offline', '--algo', 'consensus', *options, cwd=folder)
    offline = read_csv(folder / 'offline' / 'csv')

    assert result.returncode == 0
    for robot in ROBOTS:
        assert abs(offline.robots[robot].sent - record.robots[robot].sent) <= 5
