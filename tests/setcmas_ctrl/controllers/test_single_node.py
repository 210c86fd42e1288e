"""Nodes of a robot, each in a process of its own, as `ros2 run` starts them."""

import signal
import sys

import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import Point32, TwistStamped
from nav_msgs.msg import Odometry
from processes import CTRL, SIMU
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_peer import position, velocity
from std_msgs.msg import Bool, UInt16

SINGLE = [sys.executable, '-m', 'setcmas_ctrl.controllers.single_node']
LATCHED = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)


@pytest.fixture
def start_alone(start):
    """Start a node by name, in a namespace, with parameters."""

    def start_alone(name, namespace, *parameters, options=()):
        words = [word for one in parameters for word in ('-p', one)]
        return start(*SINGLE, name, *options, '--ros-args', '-r', f'__ns:={namespace}', *words)

    return start_alone


def test_single_nodes_make_up_a_fleet_with_those_of_others(start, start_alone, peer, script):
    law = script('def control(i, n, poses, t):\n    return 0.0, 9.0\n')
    start(*SIMU, '--nb-robots', '3').wait_for_output('simulating')
    odometry = [peer.odometry(robot) for robot in (1, 2, 3)]
    wanted, commands = peer.cmd_cart_vel(3), peer.cmd_vel(3)
    start(*CTRL, '--algo', 'consensus', '--robots', '1')
    controller = start_alone('controller', '/tb3_3', f'algo:={law}', 'vnom:=0.25')
    converter = start_alone('si_to_uni', '/tb3_3', 'komega:=0.5')
    peer.wait_for(lambda: odometry[2] and odometry[2][-1].twist.twist.linear.x == 0.25)

    assert (wanted[-1].x, wanted[-1].y) == (0.0, 0.25)
    assert 0.0 < velocity(commands[0])[1] < 0.8  # 0.5 pi / 2 at most
    assert peer.set_parameter('/tb3_3/controller', 'vnom', 0.125) == ''
    assert peer.set_parameter('/tb3_3/si_to_uni', 'komega', 1.0) == ''
    peer.wait_for(lambda: velocity(commands[-1])[0] == 0.125)
    peer.wait_for(lambda: odometry[0][-1].twist.twist.linear.x > 0.0)
    assert position(odometry[1][-1]) == position(odometry[1][0])

    controller.end(signal.SIGKILL)
    peer.wait_for(lambda: odometry[2][-1].twist.twist.linear.x == 0.0)
    peer.wait_for(lambda: velocity(commands[-1]) == (0.0, 0.0))  # of si_to_uni
    assert converter.end() == 0
    assert 'Traceback' not in converter.output()


def test_a_single_node_waits_for_its_robot_beside_others(start, start_alone, peer):
    start(*SIMU, '--nb-robots', '1').wait_for_output('simulating')
    converter = start_alone('si_to_uni', '/tb3_2')
    converter.wait_for_output('waiting for the odometry of robot 2')
    start(*SIMU, '--nb-robots', '3', '--robots', '2')
    converter.wait_for_output('controlling robot 2')
    start(*SIMU, '--nb-robots', '3', '--robots', '3')
    last = peer.odometry(3)
    peer.wait_for(lambda: len(last) > 70)  # after two looks at the graph

    assert converter.end() == 0
    assert 'appeared' not in converter.output()


def test_two_fleets_of_single_nodes_are_apart(start, start_alone, peer):
    for fleet in ('a', 'b'):
        rule = ('--ros-args', '-r', f'__ns:=/{fleet}')
        start(*SIMU, '--nb-robots', '1', *rule).wait_for_output('simulating')
        start_alone('si_to_uni', f'/{fleet}/tb3_1')
    odometry = {one: peer.listen(Odometry, f'/{one}/tb3_1/odom') for one in 'ab'}
    commands = {one: peer.listen(TwistStamped, f'/{one}/tb3_1/cmd_vel') for one in 'ab'}
    publishers = [peer.publisher(Point32, f'/{one}/tb3_1/cmd_cart_vel') for one in 'ab']

    def drive():
        for publisher in publishers:
            publisher.publish(Point32(x=0.25))

    peer.node.create_timer(0.1, drive)
    peer.wait_for(lambda: all(o and o[-1].twist.twist.linear.x for o in odometry.values()))
    peer.publisher(Bool, '/a/pause').publish(Bool(data=True))
    peer.wait_for(lambda: odometry['a'][-1].twist.twist.linear.x == 0.0)

    later = peer.wait_for_new(commands['b'], 5)
    assert {velocity(command)[0] for command in later} == {0.25}


def test_the_sender_of_a_robots_states_works_alone(start, start_alone, peer):
    start(*SIMU, '--nb-robots', '2').wait_for_output('simulating')
    events = peer.listen(UInt16, '/tb3_2/trig_event')
    states = peer.listen(Odometry, '/tb3_2/trig_odom', LATCHED)
    process = start_alone('event_triggered_comm', '/tb3_2', 'threshold:=0.1')
    process.wait_for_output('sending the states of robot 2 by events')
    peer.wait_for(lambda: len(states) > 3 and len(events) > 3)

    assert events[-1].data == 0
    assert len({state.header.stamp.nanosec for state in states}) == 1  # repeated: it stands
    assert process.end() == 0


@pytest.mark.parametrize(
    ('name', 'parameters', 'message'),
    [
        ('controller', ('algo:=nothing', 'nb_robots:=1'), "control script 'nothing' not found"),
        (
            'controller',
            ('robot_no:=3', 'nb_robots:=2'),
            'robot_no is 3 in namespace /tb3_1; add -r __ns:=/tb3_3',
        ),
        ('controller', ('vnom:=-1.0',), 'parameter vnom is -1; it must be above 0'),
        ('si_to_uni', ('komega:=fast',), "parameter komega is 'fast'; it must be a number"),
        ('si_to_uni', ('cmd_timeout:=soon',), "parameter cmd_timeout is 'soon'; it must be"),
        ('event_triggered_comm', ('robot_no:=0',), 'parameter robot_no is 0; it must be'),
        ('event_triggered_comm', ('ctc:=never',), "script 'never' of --ctc was not found"),
    ],
)
def test_mistakes_in_parameters_are_one_line(start_alone, name, parameters, message):
    process = start_alone(name, '/tb3_1', *parameters)

    assert process.wait() == 2
    assert message in process.output()
    assert len(process.output().strip().splitlines()) == 1
