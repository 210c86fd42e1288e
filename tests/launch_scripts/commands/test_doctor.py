import sys
import time

import pytest
from processes import SETCMAS, TIMEOUT_S

pytest.importorskip('rclpy')

from nav_msgs.msg import Odometry
from std_msgs.msg import Bool

from launch_scripts.commands.doctor import discovery_finding, domain_finding
from setcmas_expe.lab.findings import NOTE, OK, PROBLEM

LAB = [sys.executable, '-m', 'setcmas_expe.emulation.emulated_lab', '--nb-robots', '2']


def examine_until(text, start, *options):
    """Run the doctor until it reports a text; return status and output.

    Where this machine stalls for a second, it rightly reports robots that motion capture lost.
    """
    deadline = time.monotonic() + TIMEOUT_S
    while True:
        doctor = start(*SETCMAS, 'doctor', *options)
        status, output = doctor.wait(), doctor.output()
        if text in ' '.join(output.split()):
            return status, output
        assert time.monotonic() < deadline, output


def test_this_machine(start):
    doctor = start(*SETCMAS, 'doctor')
    output = doctor.wait_for_output('all well')

    assert doctor.wait() == 0
    for what in ('ROS 2', 'ROS domain', 'discovery'):
        assert what in output


@pytest.mark.nightly
def test_the_bodies_and_the_experiment_of_an_emulated_lab(start, peer, tmp_path):
    start(*LAB)
    truth = peer.odometry(1)
    peer.wait_for(lambda: truth)
    lab = tmp_path / 'lab.yaml'
    lab.write_text(
        'robots:\n'
        '- {number: 1, mocap_name: tb3_2}\n'
        '- {number: 2, mocap_name: tb3_1}\n'
        '- {number: 3}\n'
    )

    status, output = examine_until('all well', start, '--lab', str(lab), '--nb-robots', '2')
    assert status == 0
    assert 'tb3_2' in output
    assert truth[-1].pose.pose.position.x == 0.0

    peer.node.create_publisher(Bool, '/paused', 10)
    status, output = examine_until('sends tb3_1, tb3_2', start, '--lab', str(lab))
    assert status == 1
    assert 'nothing on /qualisys/tb3_3/odom' in output
    assert 'nothing listens to /tb3_3/cmd_vel' in output
    assert 'experiment one is running' in ' '.join(output.split())


def test_a_robot_without_a_guard_and_poses_of_two_senders(start, peer):
    start(*LAB, '--without-guard')
    peer.node.create_publisher(Odometry, '/qualisys/tb3_2/odom', 10)
    status, output = examine_until('2 nodes send it on', start, '--nb-robots', '2')

    assert status == 1
    assert 'guard of tb3_1 not there' in ' '.join(output.split())


@pytest.mark.parametrize(
    ('values', 'level'),
    [
        ([{'ROS_DOMAIN_ID': domain} for domain in ('', '101', '232')], OK),
        ([{'ROS_DOMAIN_ID': domain} for domain in ('102', '214')], NOTE),
        ([{'ROS_DOMAIN_ID': domain} for domain in ('233', '-1', 'a')], PROBLEM),
    ],
)
def test_domains(values, level):
    assert {domain_finding(value).level for value in values} == {level}


@pytest.mark.parametrize(
    ('variables', 'level', 'text'),
    [
        ({}, OK, 'SUBNET in experiments'),
        ({'ROS_STATIC_PEERS': '10.0.0.2'}, OK, '10.0.0.2'),
        ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCAL'}, PROBLEM, 'LOCAL'),
        ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'OFF'}, PROBLEM, 'OFF'),
        ({'ROS_LOCALHOST_ONLY': '1'}, PROBLEM, 'ROS_LOCALHOST_ONLY'),
    ],
)
def test_discovery(variables, level, text):
    finding = discovery_finding(variables)

    assert finding.level == level
    assert text in finding.found
