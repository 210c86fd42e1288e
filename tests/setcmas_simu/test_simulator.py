import json
import signal
import sys
from pathlib import Path

import numpy as np
import pytest
from processes import SIMU

pytest.importorskip('rclpy')

from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
from nav_msgs.msg import Odometry
from rcl_interfaces.srv import GetParameters
from ros_peer import position, twist_stamped
from std_msgs.msg import Empty, String
from std_srvs.srv import Trigger
from visualization_msgs.msg import Marker

from setcmas_simu.fleet.fleet import start_poses
from setcmas_simu.fleet.palettes import colour
from setcmas_simu.ros import qos

FOREIGN = Path(__file__).parents[1] / 'setcmas_expe' / 'scripts' / 'foreign_controller.py'


def test_odometry_pose_and_marker_of_every_robot(start, peer):
    start(*SIMU, '--nb-robots', '3', '--pose', '2:1,2,1.5')
    odometry = [peer.odometry(robot) for robot in (1, 2, 3)]
    pose = peer.listen(PoseStamped, '/tb3_2/pose')
    marker = peer.listen(Marker, '/tb3_2/marker')
    peer.wait_for(lambda: all(odometry) and pose and marker)

    assert odometry[0][0].header.frame_id == 'world'
    assert odometry[0][0].child_frame_id == 'tb3_1/base_footprint'
    assert position(odometry[0][0]) == tuple(start_poses(3)[:2, 0])
    assert position(odometry[1][0]) == (1.0, 2.0)
    z, w = pose[0].pose.orientation.z, pose[0].pose.orientation.w
    assert 2 * np.arctan2(z, w) == pytest.approx(1.5)
    rgb = (marker[0].color.r, marker[0].color.g, marker[0].color.b)
    assert rgb == pytest.approx(colour(2))
    assert (marker[0].pose.position.x, marker[0].pose.position.y) == (1.0, 2.0)


def test_reset_of_the_fleet_by_topic_or_service(start, peer):
    start(*SIMU, '--nb-robots', '2')
    odometry = [peer.odometry(robot) for robot in (1, 2)]
    commands = [peer.publisher(TwistStamped, f'/tb3_{robot}/cmd_vel') for robot in (1, 2)]
    reset_all = peer.publisher(Empty, '/reset')
    homes = [tuple(start_poses(2)[:2, i]) for i in (0, 1)]

    def drive_away():
        for command in commands:
            command.publish(twist_stamped(0.5, 0.0))
        peer.wait_for(
            lambda: all(position(o[-1]) != h for o, h in zip(odometry, homes, strict=True))
        )

    peer.wait_for(lambda: all(odometry))
    drive_away()
    reset_all.publish(Empty())
    peer.wait_for(lambda: all(position(o[-1]) == h for o, h in zip(odometry, homes, strict=True)))
    assert odometry[0][-1].twist.twist.linear.x == 0.0

    drive_away()
    assert peer.call(Trigger, '/virtual_robots/reset').success
    peer.wait_for(lambda: all(position(o[-1]) == h for o, h in zip(odometry, homes, strict=True)))


def test_a_sender_of_the_other_type_is_reported_once(start, peer):
    simulator = start(*SIMU, '--nb-robots', '2')
    for robot in (1, 2):
        peer.node.create_publisher(Twist, f'/tb3_{robot}/cmd_vel', 10)

    simulator.wait_for_output(
        '/tb3_1/cmd_vel and 1 more: /peer sends Twist, but the robot takes TwistStamped, so no '
        'command arrives; start simu with --cmd-vel-type twist, or send TwistStamped'
    )


@pytest.mark.nightly
def test_so_is_a_sender_without_ros(start, domain):
    pytest.importorskip('cyclonedds')
    simulator = start(*SIMU, '--nb-robots', '1', '--cmd-vel-type', 'twist')
    start(sys.executable, FOREIGN, str(domain), '1', 'cmd_vel', 'TwistStamped')

    simulator.wait_for_output(
        '/tb3_1/cmd_vel: a node without a name sends TwistStamped, but the robot takes Twist, so '
        'no command arrives; start simu with --cmd-vel-type twist_stamped, or send Twist'
    )


def test_a_single_robot_has_the_names_and_parameters_that_ros_gives_it(start, peer):
    parameters = ('x0:=2', 'y0:=-1.5', 'limits:=burger', 'rate:=50', 'child_frame_id:=base')
    parameters += ('cmd_timeout:=0',)  # so that one command is enough
    words = [word for one in parameters for word in ('-p', one)]
    process = start(*SIMU, '--ros-args', '-r', '__ns:=/lab/tb3_3', *words)
    process.wait_for_output('simulating robot 3 at 50 Hz')
    odometry = peer.listen(Odometry, '/lab/tb3_3/odom')
    fleet = peer.listen(String, '/lab/fleet', qos.LATCHED_BY_MANY)
    peer.wait_for(lambda: odometry and fleet)

    assert position(odometry[0]) == (2.0, -1.5)
    assert odometry[0].child_frame_id == 'base'
    assert peer.node.count_services('/lab/tb3_3/virtual_robot/set_parameters') == 1
    assert json.loads(fleet[0].data)['robots'] == [3]
    publisher = peer.publisher(TwistStamped, '/lab/tb3_3/cmd_vel')
    publisher.publish(twist_stamped(1.0, 0.0))
    peer.wait_for(lambda: 0.0 < odometry[-1].twist.twist.linear.x < 0.3)
    assert peer.set_parameter('/lab/tb3_3/virtual_robot', 'limits', 'ideal') == ''
    peer.wait_for(lambda: odometry[-1].twist.twist.linear.x == 1.0)
    assert peer.call(Trigger, '/lab/tb3_3/virtual_robot/reset').success
    peer.wait_for(lambda: position(odometry[-1]) == (2.0, -1.5))


def test_a_single_robot_takes_options_too(start, peer):
    options = ('--pose', '1:2,1', '--limits', 'waffle')
    start(*SIMU, *options, '--ros-args', '-r', '__ns:=/tb3_1')
    odometry = peer.odometry(1)
    peer.wait_for(lambda: odometry)

    assert position(odometry[0]) == (2.0, 1.0)
    described = peer.call(GetParameters, '/tb3_1/virtual_robot/get_parameters', names=['limits'])
    assert described.values[0].string_value == 'waffle'


def test_parameters_in_a_file_and_set_while_it_runs(start, peer, tmp_path):
    file = tmp_path / 'parameters.yaml'
    file.write_text('/virtual_robots:\n  ros__parameters: {rate: 50, limits: burger}\n')
    poses = tmp_path / 'poses.yaml'
    poses.write_text('- [0, 0, 0]\n- [1, 1, 0]\n')
    options = ('--nb-robots', '2', '--poses', str(poses), '--cmd-timeout', '0')
    simulator = start(*SIMU, *options, '--ros-args', '--params-file', str(file))
    simulator.wait_for_output('simulating robots 1-2 at 50 Hz')
    poses.unlink()  # its poses are known
    odometry = peer.odometry(1)
    peer.publisher(TwistStamped, '/tb3_1/cmd_vel').publish(twist_stamped(1.0, 0.0))
    peer.wait_for(lambda: odometry and 0.0 < odometry[-1].twist.twist.linear.x < 0.3)
    assert peer.set_parameter('/virtual_robots', 'limits', 'ideal') == ''
    assert peer.set_parameter('/virtual_robots', 'rate', 20) == ''

    def last_step():
        return position(odometry[-1])[0] - position(odometry[-2])[0]

    # Steps may be missed, if busy.
    peer.wait_for(lambda: len(odometry) > 1 and last_step() == pytest.approx(1 / 20))
    assert 'rate is 20 from now on' in simulator.output()


def test_robots_of_fleets_above_20_have_no_services_of_their_own(start, peer):
    start(*SIMU, '--nb-robots', '21', '--ros-args', '-r', '__ns:=/many')
    start(*SIMU, '--nb-robots', '20', '--ros-args', '-r', '__ns:=/few')
    for fleet in ('many', 'few'):
        reason = peer.set_parameter(f'/{fleet}/virtual_robots', 'cmd_timeout', 0.1)
        assert 'it must be at least 0.3 s' in reason

    def services():
        names = {name for name, _ in peer.node.get_service_names_and_types()}
        return {name.split('/')[1] for name in names if '/virtual_robot/' in name}

    peer.wait_for(services)
    peer.wait_for_new(peer.listen(Odometry, '/many/tb3_21/odom'))
    peer.wait_for_new(peer.listen(Odometry, '/few/tb3_20/odom'))
    assert services() == {'few'}
    assert peer.set_parameter('/few/tb3_20/virtual_robot', 'cmd_timeout', 0.5) == ''


def test_a_part_of_a_fleet_starts_where_it_does_in_the_whole(start, peer):
    start(*SIMU, '--nb-robots', '8', '--robots', '5-6')
    odometry = [peer.odometry(robot) for robot in (1, 5, 6)]
    peer.wait_for(lambda: odometry[1] and odometry[2])

    assert not odometry[0]
    assert position(odometry[1][0]) == (0.0, 5.0)
    assert position(odometry[2][0]) == (5.0, 0.0)


@pytest.mark.nightly
def test_a_second_simulator_of_the_same_robots_refuses_to_start(start, peer):
    first = start(*SIMU, '--nb-robots', '4')
    first.wait_for_output('simulating robots 1-4')
    odometry = peer.odometry(3)

    second = start(*SIMU, '--nb-robots', '3')
    assert second.wait() == 2
    assert 'robots 1-3 are already simulated in ROS domain' in second.output()
    assert '(node /tb3_1/virtual_robot publishes odometry)' in second.output()
    third = start(*SIMU, '--robots', '5-6')
    third.wait_for_output('simulating robots 5-6')

    peer.wait_for_new(odometry, 5)


def test_a_second_publisher_of_odometry_that_was_not_seen_at_the_start_is_told_of(start, peer):
    simulator = start(*SIMU, '--nb-robots', '2')
    simulator.wait_for_output('simulating robots 1-2')

    peer.node.create_publisher(Odometry, '/tb3_2/odom', 1)

    simulator.wait_for_output('the odometry of robot 2 has two publishers')


def test_after_a_crash_a_simulator_can_be_started_again(start):
    first = start(*SIMU, '--nb-robots', '2')
    first.wait_for_output('simulating')
    first.end(signal.SIGKILL)

    start(*SIMU, '--nb-robots', '2').wait_for_output('simulating robots 1-2')


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (('--model', '1:segway'), "unknown robot model 'segway'"),
        (('--ros-args', '-p', 'foo'), 'invalid arguments after --ros-args'),
    ],
)
def test_mistakes_are_reported_without_a_traceback(start, arguments, message):
    process = start(*SIMU, *arguments)

    assert process.wait() == 2
    assert message in process.output()
    assert 'Traceback' not in process.output()
