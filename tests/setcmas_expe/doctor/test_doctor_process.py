import sys

import pytest
from processes import SETCMAS

pytest.importorskip('rclpy')

from nav_msgs.msg import Odometry
from std_msgs.msg import Bool, String

LAB = [sys.executable, '-m', 'setcmas_expe.emulation.emulated_lab', '--nb-robots', '2']
DOCTOR = [*SETCMAS, 'doctor']


def test_this_machine(start):
    doctor = start(*DOCTOR)
    output = doctor.wait_for_output('all well')

    assert doctor.wait() == 0
    for what in ('Python', 'ROS 2', 'ROS domain', 'discovery', 'multicast'):
        assert what in output
    assert 'none in sight' in output


@pytest.mark.nightly
def test_an_emulated_lab_that_is_well_is_nudged(start):
    doctor = start(*DOCTOR, '--emulate', '--nb-robots', '2', '--mocap', 'optitrack', '--nudge')
    output = doctor.wait_for_output('all well')

    assert doctor.wait() == 0
    for robot in ('tb3_1', 'tb3_2'):
        assert f'ok  nudge of {robot}' in output
        assert f'ok  turn of {robot}' in output


@pytest.mark.nightly
def test_exchanged_bodies_and_nothing_moves_unasked(start, peer, tmp_path):
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

    doctor = start(*DOCTOR, '--lab', str(lab), '--nb-robots', '2')
    doctor.wait_for_output('robots of')
    assert doctor.wait() == 0
    assert 'nudge' not in doctor.output()
    assert truth[-1].pose.pose.position.x == 0.0

    doctor = start(*DOCTOR, '--lab', str(lab), '--nb-robots', '2', '--nudge')
    output = doctor.wait_for_output('problem')
    assert doctor.wait() == 1
    assert 'tb3_2 moves as robot 1 should' in output
    assert 'are their names exchanged?' in output

    doctor = start(*DOCTOR, '--lab', str(lab))
    output = doctor.wait_for_output('problem')
    assert doctor.wait() == 1
    assert 'nothing on /qualisys/tb3_3/odom' in output
    assert 'nothing listens to /tb3_3/cmd_vel' in output
    assert 'sends tb3_1, tb3_2' in ' '.join(output.split())


def test_no_nudge_while_an_experiment_runs(start, peer):
    start(*LAB)
    peer.node.create_publisher(Bool, '/paused', 10)

    doctor = start(*DOCTOR, '--nb-robots', '2', '--nudge')
    output = doctor.wait_for_output('problem')
    assert doctor.wait() == 1
    assert 'an experiment is running' in output


def test_a_robot_without_a_guard_is_not_nudged(start, peer):
    start(*LAB, '--without-guard')
    truth = peer.odometry(1)

    doctor = start(*DOCTOR, '--nb-robots', '2', '--nudge')
    output = doctor.wait_for_output('problem')
    assert doctor.wait() == 1
    assert 'nudge of tb3_1  no nudge: no cmd_vel_guard on it' in output
    assert all(message.twist.twist.linear.x == 0.0 for message in truth)


@pytest.mark.nightly
def test_no_nudge_by_poses_of_two_senders(start, peer):
    start(*LAB)
    truth = peer.odometry(1)
    peer.node.create_publisher(Odometry, '/qualisys/tb3_2/odom', 10)

    doctor = start(*DOCTOR, '--nb-robots', '2', '--nudge')
    doctor.wait_for_output('problem')
    assert doctor.wait() == 1
    output = ' '.join(doctor.output().split())
    assert 'no nudge: 2 nodes send it on /qualisys/tb3_2/odom' in output
    assert all(message.twist.twist.linear.x == 0.0 for message in truth)


def test_a_mistake_in_the_lab_file_is_reported_in_one_line(start, tmp_path):
    lab = tmp_path / 'lab.yaml'
    lab.write_text('arena: {x: [1, -1]}\n')

    doctor = start(*DOCTOR, '--lab', str(lab))
    assert doctor.wait() == 2
    assert len(doctor.output().splitlines()) == 1
    assert 'line 1' in doctor.output()


def test_faults_are_injected_and_those_of_no_robot_are_reported(start, peer):
    lab = start(*LAB)
    lab.wait_for_output('emulating')
    order = peer.publisher(String, '/emulated_lab/fault')

    fault = start(*SETCMAS, 'fault', 'dropout', '--robot', '2', '--for', '1.5')
    assert fault.wait() == 0
    lab.wait_for_output('robot 2, for 1.5 s: motion capture sends nothing')

    order.publish(String(data='nan 3'))
    lab.wait_for_output('the lab has robots 1 to 2')


def test_without_an_emulated_lab_a_fault_says_so(start):
    fault = start(*SETCMAS, 'fault', 'nan')

    assert fault.wait() == 2
    assert 'there is no emulated lab' in fault.output()
