import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import Point32, Twist, TwistStamped
from nav_msgs.msg import Odometry
from processes import CTRL, SIMU


def test_the_robot_decides_the_type_when_others_listen_too(start, peer):
    peer.cmd_vel(1, TwistStamped)
    start(*SIMU, '--nb-robots', '1', '--pose', '1:3,3', '--cmd-vel-type', 'twist')
    odometry = peer.odometry(1)
    process = start(*CTRL, '--algo', 'nav_wp')

    peer.wait_for(lambda: odometry and odometry[-1].twist.twist.linear.x > 0.1)
    process.wait_for_output('/tb3_1/cmd_vel carries Twist, but /peer takes TwistStamped')


def test_it_says_when_nothing_listens_to_the_commands(start, peer):
    publisher = peer.node.create_publisher(Odometry, '/tb3_1/odom', 10)
    peer.node.create_timer(0.1, lambda: publisher.publish(Odometry()))
    process = start(*CTRL, '--algo', 'nav_wp', '--nb-robots', '1')

    peer.wait_for(lambda: 'nothing listens to cmd_vel of robot 1' in process.output())


@pytest.mark.nightly
def test_a_second_controller_of_a_robot_is_noticed(start):
    start(*SIMU, '--nb-robots', '1').wait_for_output('simulating')
    first = start(*CTRL, '--algo', 'nav_wp')
    first.wait_for_output('controlling')
    start(*CTRL, '--algo', 'nav_wp')

    first.wait_for_output('another controller also commands robot 1 (/tb3_1/si_to_uni)')


@pytest.mark.nightly
def test_several_publishers_of_a_velocity_are_named_in_one_line(start, peer):
    start(*SIMU, '--nb-robots', '3').wait_for_output('simulating')
    for robot in (2, 3):
        peer.publisher(Point32, f'/tb3_{robot}/cmd_cart_vel', listeners=0)
    laws = start(*CTRL, '--algo', 'nav_wp')
    laws.wait_for_output(
        '/tb3_2/cmd_cart_vel is published by /peer and /tb3_2/controller (and so for robot 3); '
        'the robot follows all of them: stop all but one'
    )


@pytest.mark.nightly
def test_a_controller_that_was_killed_is_no_second_one(start, peer):
    start(*SIMU, '--nb-robots', '1').wait_for_output('simulating')
    killed = start(*CTRL, '--algo', 'nav_wp')
    killed.wait_for_output('controlling')

    def commanders():
        found = peer.node.get_publishers_info_by_topic('/tb3_1/cmd_vel')
        return {bytes(one.endpoint_gid) for one in found if one.node_name == 'si_to_uni'}

    peer.wait_for(commanders)
    dead = commanders()
    killed.kill_group()
    again = start(*CTRL, '--algo', 'nav_wp')
    again.wait_for_output('controlling')  # who was killed is still in the graph, as a rule
    peer.wait_for(lambda: commanders() and not commanders() & dead)
    assert 'another controller also commands' not in again.output()


def test_the_type_of_the_commands_can_be_forced_which_is_reported_once(start, peer):
    start(*SIMU, '--nb-robots', '3').wait_for_output('simulating')
    plain = peer.cmd_vel(1, Twist)
    process = start(*CTRL, '--algo', 'nav_wp', '--cmd-vel-type', 'twist')

    peer.wait_for(lambda: plain)
    process.wait_for_output(
        '/tb3_1/cmd_vel carries Twist, but /tb3_1/virtual_robot takes TwistStamped '
        '(and so for robots 2-3); choose with --cmd-vel-type'
    )
