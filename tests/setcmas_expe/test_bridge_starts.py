"""Robots start because a person starts them, never because a message comes (back)."""

import signal
import sys
import time

import pytest

pytest.importorskip('rclpy')

from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Point32, TwistStamped
from lab_peer import BRIDGES, HZ, LabPeer
from nav_msgs.msg import Odometry
from processes import PATIENT_LAB
from rclpy.node import Node
from ros_peer import Peer
from std_msgs.msg import Bool
from std_srvs.srv import SetBool

from setcmas_ctrl.pause_watch import SURE_AFTER_S

GUARDED = ['--ros-args', '-r', '__ns:=/tb3_1']
STOP = (0.0, 0.0)
GO = (0.1, 0.2)


@pytest.fixture
def bridges(start):
    return start(*BRIDGES)


@pytest.fixture
def lab(peer, bridges):
    lab = LabPeer(peer, ('tb3_1',))
    lab.poses[1], lab.wanted[1] = (-1.0, 0.0, 0.5), GO
    return lab


@pytest.fixture
def base(domain):
    """Take part as the process of a robot's base."""
    with Peer(domain) as base:
        yield base


@pytest.fixture
def wheels(peer):
    """Return the wheel odometry that the robot sends."""
    wheels = Odometry()
    odometry = peer.node.create_publisher(Odometry, '/tb3_1/odom', 10)
    peer.node.create_timer(0.05, lambda: odometry.publish(wheels))
    return wheels


def see_it_stand(lab, reason):
    lab.peer.wait_for(lambda: reason in lab.status(1)[0].message)
    lab.commands[1].clear()
    lab.peer.wait_for_new(lab.commands[1], 10)
    assert lab.last(1) == STOP
    assert all(m.twist.linear.x == 0.0 for m in lab.commands[1])


def test_a_robot_to_whose_topic_nothing_listens_is_not_ready(peer, bridges):
    lab = LabPeer(peer, ('another_robot',))
    lab.poses[1], lab.wanted[1], lab.paused = (-1.0, 0.0, 0.5), GO, True
    line = 'nothing listens to /tb3_1/cmd_vel: is its bringup running'
    peer.wait_for(lambda: line in lab.status(1)[0].message)


def test_a_pause_node_that_returns_starts_nothing(lab):
    lab.paused = False  # as of an earlier experiment
    see_it_stand(lab, 'sent a start without a pause before it')

    lab.let_go({1: GO})
    lab.paused = None
    lab.wait_for_command(1, STOP)

    lab.paused = False
    see_it_stand(lab, 'sent a start without a pause before it')


def test_a_stopped_robot_waits_until_a_person_starts_it_again(lab):
    lab.let_go({1: GO})
    pose, lab.poses[1] = lab.poses[1], None
    see_it_stand(lab, 'paused: robot 1: no good pose for 0.5 s')
    lab.peer.wait_for(lambda: lab.status(1)[1]['speed'] == '')
    lab.poses[1] = pose
    lab.peer.wait_for(lambda: lab.status(1)[0].message.endswith('no good pose for 0.5 s'))
    see_it_stand(lab, 'paused: robot 1: no good pose for 0.5 s')

    lab.let_go({1: GO})


def slips_in_late(lab):
    """Say go and at once pause; returns whether that took so long that it was a start."""
    begin = time.monotonic()
    for lab.paused in (False, True):
        lab.peer.spin(0.1)
    return time.monotonic() - begin > SURE_AFTER_S


def test_a_forged_go_between_pauses_starts_nothing(lab):
    lab.let_go({1: GO})
    held_up = True
    while held_up:  # a machine that is busy says go for longer than for a moment
        lab.paused = True
        lab.wait_for_command(1, STOP)
        lab.commands[1].clear()
        held_up = any(slips_in_late(lab) for _ in range(5))

    assert all(m.twist.linear.x == 0.0 for m in lab.commands[1])


def test_a_bridge_that_hung_or_slept_with_the_laptop_starts_nothing(lab, bridges):
    lab.let_go({1: GO})
    bridges.popen.send_signal(signal.SIGSTOP)
    lab.peer.spin(1.0)
    bridges.popen.send_signal(signal.SIGCONT)

    bridges.wait_for_output('the bridge process stalled')
    see_it_stand(lab, 'sent a start without a pause before it')


def test_a_robot_stands_while_another_node_commands_it(lab, domain):
    lab.let_go({1: GO})
    with Peer(domain) as other:  # a process of its own, as DDS sees it
        rogue = Node('rogue', namespace='tb3_1', context=other.context)
        rogue.create_publisher(TwistStamped, '/tb3_1/cmd_vel', 1)
        see_it_stand(lab, 'paused: robot 1: /tb3_1/rogue also commands it')
        rogue.destroy_node()
    lab.peer.wait_for(lambda: lab.peer.node.count_publishers('/tb3_1/cmd_vel') == 1)
    lab.peer.spin(1.0)
    see_it_stand(lab, 'paused: robot 1: /tb3_1/rogue also commands it')

    lab.let_go({1: GO})


@pytest.mark.parametrize(('V', 'omega'), [(0.2, 0.0), (0.0, 2.0)])
def test_a_robot_that_moves_against_a_commanded_zero_is_reported(lab, bridges, V, omega):
    lab.let_go({1: GO})
    begin = lab.ticks

    def pushed():
        spent = (lab.ticks - begin) / HZ  # frame by frame: it never jumps, however busy we are
        lab.poses[1] = (-1.0 + V * spent, 0.0, 0.5 + omega * spent)
        lab.paused = spent > 0.5
        return lab.status(1)[1]['runs_away'] == 'True'

    lab.peer.wait_for(pushed)
    bridges.wait_for_output(
        'robot 1 does not obey zero commands: it has no motor_power: switch it off'
    )


def test_a_robot_that_has_stood_and_then_moves_is_carried(lab, bridges):
    lab.let_go({1: GO})
    lab.paused = True
    lab.peer.wait_for(lambda: lab.status(1)[1]['speed'] in ('0.0', '-0.0'))
    begin, told = lab.ticks, set()

    def carried():
        spent = (lab.ticks - begin) / HZ
        lab.poses[1] = (-1.0 + 0.2 * spent, 0.0, 0.5)
        told.add(lab.status(1)[1]['runs_away'])
        return spent > 3.0

    lab.peer.wait_for(carried)
    assert told == {'False'}


def test_a_robot_starts_only_with_a_guard_and_stops_without(start, peer, base):
    lab = LabPeer(peer, ('tb3_1',))
    lab.poses[1], lab.wanted[1] = (-1.0, 0.0, 0.5), GO
    lab.paused = True
    base.listen(TwistStamped, '/tb3_1/cmd_vel_guarded')
    base.node.create_publisher(Odometry, '/tb3_1/odom', 1)
    # A machine that holds this process up is not to stop the robot before its guard does.
    start(
        *[word for word in BRIDGES if word != '--without-guard'], *PATIENT_LAB[1:]
    )  # not emulated
    see_it_stand(lab, 'paused; no cmd_vel_guard on it')
    guard = start(sys.executable, '-m', 'setcmas_expe.guard.guard_node', *GUARDED)
    peer.wait_for(lambda: lab.status(1)[0].message == 'paused')
    lab.paused = False
    lab.wait_for_command(1, GO)

    guard.popen.kill()
    see_it_stand(lab, 'paused: robot 1: its cmd_vel_guard is silent')


def test_two_robots_that_were_set_up_as_one_stand(lab, domain):
    lab.let_go({1: GO})
    with Peer(domain) as other:
        robots = [
            Node('turtlebot3_node', namespace='tb3_1', context=peer.context)
            for peer in (lab.peer, other)
        ]
        for robot in robots:
            robot.create_subscription(TwistStamped, 'cmd_vel', print, 10)

        see_it_stand(lab, 'several robots listen to /tb3_1/cmd_vel')
        for robot in robots:
            robot.destroy_node()


@pytest.mark.parametrize(
    ('kind', 'topic', 'reason'),
    [
        (Odometry, '/tb3_1/odom', '2 nodes send its wheel odometry'),
        (Odometry, '/mocap/tb3_1/odom', '2 nodes send its poses (/mocap/tb3_1/odom; a killed one'),
        (Odometry, '/qualisys/tb3_1/odom', '2 nodes send it on /qualisys/tb3_1/odom'),
        (TwistStamped, '/tb3_1/cmd_vel_wanted', '2 controllers command it'),
        (Point32, '/tb3_1/cmd_cart_vel', '2 nodes command it (/tb3_1/cmd_cart_vel; a killed one'),
        (Point32, '/tb3_1/cmd_cart_vel_allowed', '2 nodes command it (/tb3_1/cmd_cart_vel_a'),
        (DiagnosticStatus, '/mocap/tb3_1/pose_state', '2 nodes judge its poses'),
    ],
)
def test_a_robot_whose_poses_or_commands_two_nodes_send_stands(lab, kind, topic, reason):
    lab.let_go({1: GO})
    for _ in range(2 if topic == '/tb3_1/odom' or 'cart' in topic else 1):
        lab.peer.node.create_publisher(kind, topic, 1)

    see_it_stand(lab, reason)


def test_the_end_of_a_second_experiment_starts_nothing(lab):
    lab.let_go({1: GO})
    second = lab.peer.node.create_publisher(Bool, '/paused', 1)
    lab.wait_for_command(1, STOP)
    lab.peer.wait_for(lambda: 'several pause nodes' in lab.status(1)[0].message)
    lab.peer.node.destroy_publisher(second)

    see_it_stand(lab, 'several pause nodes')


def test_a_paused_robot_that_is_pushed_needs_no_more_than_the_start(peer, wheels, bridges, lab):
    motors = []

    def switch(request, response):
        motors.append(request.data)
        response.success = True
        return response

    peer.node.create_service(SetBool, '/tb3_1/motor_power', switch)
    lab.paused = True
    peer.wait_for(lambda: lab.status(1)[0].message == 'paused')
    assert motors == []
    lab.let_go({1: GO})
    peer.wait_for(lambda: motors == [True])  # an earlier experiment may have cut them
    motors.clear()
    lab.paused = True
    peer.wait_for(lambda: lab.status(1)[0].message == 'paused')
    peer.spin(1.0)  # it comes to rest

    wheels.twist.twist.linear.x = 0.1
    peer.wait_for(lambda: False in motors)
    bridges.wait_for_output(
        'robot 1 does not obey zero commands: its motors are off until the next start'
    )
    wheels.twist.twist.linear.x = 0.0
    peer.wait_for(lambda: lab.status(1)[0].message == 'paused')
    assert True not in motors
    reports = [status for message in lab.diagnostics for status in message.status]
    told = [one.value for r in reports for one in r.values if one.key == 'runs_away']
    assert 'True' not in told
    lab.let_go({1: GO})
    wheels.twist.twist.linear.x = 0.1
    peer.wait_for(lambda: motors[-1] is True)


def test_a_robot_without_motor_power_is_to_be_switched_off(peer, wheels, bridges, lab):
    wheels.twist.twist.linear.x = 0.1
    lab.paused = True
    line = 'robot 1 does not obey zero commands: it has no motor_power: switch it off'
    peer.wait_for(lambda: line in bridges.output())
    for _ in range(3):  # while it does not stop
        lab.diagnostics.clear()
        peer.wait_for(lambda: lab.status(1)[1]['runs_away'] == 'True')
