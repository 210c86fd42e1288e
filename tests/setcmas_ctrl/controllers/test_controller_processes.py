"""The processes of controllers: of a fleet, and of single nodes as `ros2 run` starts them."""

import signal

import pytest
from processes import CTRL, SIMU

pytest.importorskip('rclpy')

import rclpy
from geometry_msgs.msg import Point32, TwistStamped
from nav_msgs.msg import Odometry
from rcl_interfaces.srv import GetParameters
from ros_peer import position, velocity
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Bool, UInt16

from setcmas_simu.ros import qos
from setcmas_simu.ros.fleet_topic import Announcement, FleetAnnouncer


def test_each_robot_has_parameters_of_its_own(start, peer, script, tmp_path):
    law = script('def control(i, n, p, t):\n    return 9, 0\n')
    file = tmp_path / 'gains.yaml'
    file.write_text('/tb3_2/controller:\n  ros__parameters: {vnom: 0.125}\n')
    start(*SIMU, '--nb-robots', '2')
    wanted = [peer.cmd_cart_vel(robot) for robot in (1, 2)]
    arguments = ('--vnom', '0.25', '--ros-args', '--params-file', str(file))
    start(*CTRL, '--algo', law, *arguments)

    def are_wanted(*speeds):
        peer.wait_for(lambda: all(wanted) and [one[-1].x for one in wanted] == [*speeds])

    are_wanted(0.25, 0.125)
    assert peer.set_parameter('/tb3_1/controller', 'vnom', 0.5) == ''
    are_wanted(0.5, 0.125)
    assert peer.set_parameter('/controllers', 'vnom', 1.0) == ''  # for all of them
    are_wanted(1.0, 1.0)

    def komegas():
        names = {'names': ['komega']}
        nodes = [f'/tb3_{robot}/si_to_uni/get_parameters' for robot in (1, 2)]
        return [peer.call(GetParameters, one, **names).values[0].double_value for one in nodes]

    assert peer.set_parameter('/tb3_1/si_to_uni', 'komega', 3.0) == ''
    assert komegas() == [3.0, 1.5]
    assert peer.set_parameter('/controllers', 'komega', 2.0) == ''
    peer.wait_for(lambda: komegas() == [2.0, 2.0])
    for node, name in (('controller', 'rate'), ('si_to_uni', 'vnom')):
        assert peer.set_parameter(f'/tb3_1/{node}', name, 1.0) != ''  # not theirs


def test_another_program_drives_robots_in_place_of_a_law(start, peer):
    start(*SIMU, '--nb-robots', '2').wait_for_output('simulating')
    process = start(*CTRL, '--algo', 'external')
    process.wait_for_output('controlling robots 1-2 with velocities of others')
    odometry = [peer.odometry(robot) for robot in (1, 2)]
    publisher = peer.publisher(Point32, '/tb3_2/cmd_cart_vel')
    timer = peer.node.create_timer(0.1, lambda: publisher.publish(Point32(x=0.25)))

    def speed():
        return odometry[1][-1].twist.twist.linear.x

    peer.wait_for(lambda: all(odometry) and speed() == 0.25)
    assert position(odometry[0][-1]) == position(odometry[0][0])
    timer.cancel()
    peer.wait_for(lambda: speed() == 0.0)
    assert process.end() == 0


def test_it_waits_for_a_recorder_that_records_the_robots_too(start, peer):
    recorder = rclpy.create_node('recorder', context=peer.context)
    recorder.create_subscription(TwistStamped, '/tb3_1/cmd_vel', print, 10)
    commands = peer.cmd_vel(1)
    start(*SIMU, '--nb-robots', '1')
    process = start(*CTRL, '--algo', 'consensus', '--nb-robots', '1', '--recorded')
    peer.wait_for(lambda: 'controllers' in peer.node.get_node_names())
    peer.spin(2.0)
    assert not commands
    assert 'controlling' not in process.output()

    recorder.create_subscription(Odometry, '/tb3_1/odom', print, 10)
    peer.wait_for(lambda: commands)
    recorder.destroy_node()


def test_controllers_wait_for_a_fleet_and_then_for_its_other_part(start):
    process = start(*CTRL, '--algo', 'consensus')
    process.wait_for_output('waiting for a fleet')
    start(*SIMU, '--nb-robots', '4', '--robots', '1-2')
    process.wait_for_output('waiting for the odometry of robots 3-4')
    start(*SIMU, '--nb-robots', '4', '--robots', '3-4')

    process.wait_for_output('controlling robots 1-4')


def test_requests_are_answered_while_it_waits_for_odometry(start, peer, script):
    law = script('def control(i, n, p, t):\n    return 9, 0\n')
    FleetAnnouncer(peer.node).announce(Announcement(1, (1,)))
    process = start(*CTRL, '--algo', law)
    process.wait_for_output('waiting for the odometry of robot 1 (/tb3_1/odom)')
    assert peer.set_parameter('/tb3_1/controller', 'vnom', 0.25) == ''
    assert peer.set_parameter('/controllers', 'komega', 1.0) == ''
    pause = peer.publisher(Bool, '/pause')
    pause.publish(Bool(data=True))
    process.wait_for_output('paused by /pause')

    wanted = peer.cmd_cart_vel(1)
    odometry = peer.node.create_publisher(Odometry, '/tb3_1/odom', 1)
    peer.node.create_timer(0.05, lambda: odometry.publish(Odometry()))
    peer.wait_for(lambda: wanted)
    assert wanted[0].x == 0.0  # paused
    pause.publish(Bool(data=False))
    peer.wait_for(lambda: wanted[-1].x == 0.25)


def test_fleets_in_two_namespaces_are_apart(start, peer):
    for fleet in ('/a', '/b'):
        robots = start(*SIMU, '--nb-robots', '2', '--ros-args', '-r', f'__ns:={fleet}')
        robots.wait_for_output('simulating robots 1-2')
    driven, other = (peer.listen(Odometry, f'/{fleet}/tb3_1/odom') for fleet in 'ab')
    start(*CTRL, '--algo', 'consensus', '--ros-args', '-r', '__ns:=/a')

    peer.wait_for(lambda: driven and other and position(driven[-1]) != position(driven[0]))
    assert position(other[-1]) == position(other[0])
    names = {name for name, _ in peer.node.get_topic_names_and_types()}
    outside = {name for name in names if not name.startswith(('/a/', '/b/', '/peer/'))}
    assert outside == {'/rosout', '/parameter_events'}


def test_use_sim_time_follows_the_clock_of_another_simulator(start, peer, script):
    law = script('def control(i, n, p, t):\n    return 0.0, 0.01 * t\n')
    wanted, commands = peer.cmd_cart_vel(1), peer.cmd_vel(1)
    clock = peer.node.create_publisher(Clock, '/clock', 1)
    odometry = peer.node.create_publisher(Odometry, '/tb3_1/odom', 1)
    now, ticks = Clock(), []
    now.clock.sec = 100

    def publish():
        clock.publish(now)
        odometry.publish(Odometry())
        ticks.append(now)

    peer.node.create_timer(0.02, publish)
    options = ('--nb-robots', '1', '--ros-args', '-p', 'use_sim_time:=true')
    start(*CTRL, '--algo', law, *options)
    peer.wait_for(lambda: wanted)
    peer.wait_for_new(ticks, 30)
    assert len(wanted) == 1  # the clock stands still
    for _ in range(30):  # a second after the other, faster than the laws' period
        now.clock.sec += 1
        peer.wait_for_new(wanted)

    peer.wait_for(lambda: commands[-1].header.stamp.sec == 130)
    assert wanted[-1].y == pytest.approx(0.3)


@pytest.fixture
def start_alone(start):
    """Start a node by name, in a namespace, with parameters."""

    def start_alone(name, namespace, *parameters, options=()):
        words = [word for one in parameters for word in ('-p', one)]
        return start(*CTRL, name, *options, '--ros-args', '-r', f'__ns:={namespace}', *words)

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


def test_the_sender_of_a_robots_states_works_alone(start, start_alone, peer):
    start(*SIMU, '--nb-robots', '2').wait_for_output('simulating')
    events = peer.listen(UInt16, '/tb3_2/trig_event')
    states = peer.listen(Odometry, '/tb3_2/trig_odom', qos.LATCHED_BY_MANY)
    process = start_alone('event_triggered_comm', '/tb3_2', 'threshold:=0.1')
    process.wait_for_output('sending the states of robot 2 by events')
    peer.wait_for(lambda: len(states) > 3 and len(events) > 3)

    assert events[-1].data == 0
    assert len({state.header.stamp.nanosec for state in states}) == 1  # repeated: it stands
    assert process.end() == 0


@pytest.mark.parametrize(
    ('name', 'parameters', 'message'),
    [
        ('controller', ('algo:=nothing', 'nb_robots:=1'), "script 'nothing' of --algo not found"),
        (
            'controller',
            ('robot_no:=3', 'nb_robots:=2'),
            'robot_no is 3 in namespace /tb3_1; add -r __ns:=/tb3_3',
        ),
        ('controller', ('vnom:=-1.0',), 'parameter vnom is -1; it must be above 0'),
        ('si_to_uni', ('komega:=fast',), "parameter komega is 'fast'; it must be a number"),
        ('si_to_uni', ('cmd_timeout:=soon',), "parameter cmd_timeout is 'soon'; it must be"),
        ('event_triggered_comm', ('robot_no:=0',), 'parameter robot_no is 0; it must be'),
        ('event_triggered_comm', ('ctc:=never',), "script 'never' of --ctc not found"),
    ],
)
def test_mistakes_in_parameters_are_one_line(start_alone, name, parameters, message):
    process = start_alone(name, '/tb3_1', *parameters)

    assert process.wait() == 2
    assert message in process.output()
    assert len(process.output().strip().splitlines()) == 1


def test_the_filter_is_refused_for_a_part_of_a_fleet_before_there_is_one(start):
    process = start(*CTRL, '--algo', 'nav_wp', '--robots', '1-2', '--filter', 'barrier')

    assert process.wait() == 2
    assert 'add --nb-robots 2 if robots 1-2 are all, leave out --robots' in process.output()


def test_the_filter_runs_for_robots_that_are_the_whole_fleet(start):
    of_all = ('--nb-robots', '2', '--robots', '1-2', '--filter', 'barrier')
    start(*CTRL, '--algo', 'nav_wp', *of_all).wait_for_output('waiting for')
