"""The node of a virtual robot by itself: a peer sends its commands, and hears where it is."""

import math

import numpy as np
import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message
from ros_peer import position, twist_stamped
from std_msgs.msg import Empty
from stepped_alone import SteppedAlone

from setcmas_simu.errors import SetcmasError
from setcmas_simu.simulation_options import SimulationOptions
from setcmas_simu.virtual_robot import VirtualRobot


@pytest.fixture
def stepped():
    return SteppedAlone()


@pytest.fixture
def robot_with(peer, stepped):
    """Return a function that creates robot 3 with arguments of ROS and options."""

    def create(*given, **options):
        words = [word for one in given for word in ('-p', one)]
        of_node = stepped.arguments(peer, '-r', '__ns:=/tb3_3', *words)
        robot = peer.add(VirtualRobot(options=SimulationOptions(**options), **of_node))
        stepped.nodes = [robot]
        return robot

    return create


@pytest.fixture
def cmd_vel(peer):
    def publisher(kind=TwistStamped):
        return peer.publisher(kind, '/tb3_3/cmd_vel')

    return publisher


def test_a_command_moves_the_robot_from_its_start(peer, stepped, robot_with, cmd_vel):
    robot_with('x0:=1', 'y0:=-2.0', 'theta0:=0.5', 'child_frame_id:=base')
    odometry = peer.odometry(3)
    stepped.step()
    peer.wait_for(lambda: odometry)
    first = odometry[0]
    assert position(first) == (1.0, -2.0)
    turn = first.pose.pose.orientation
    assert 2 * math.atan2(turn.z, turn.w) == pytest.approx(0.5)
    assert (first.header.frame_id, first.child_frame_id) == ('world', 'base')

    cmd_vel().publish(twist_stamped(0.4, 0.0))
    stepped.step(4)
    peer.wait_for(lambda: len(odometry) == 5)
    way = 4 * 0.125 * 0.4
    there = (1.0 + way * math.cos(0.5), -2.0 + way * math.sin(0.5))
    assert position(odometry[-1]) == pytest.approx(there)
    assert odometry[-1].twist.twist.linear.x == 0.4


@pytest.mark.parametrize(('timeout', 'way'), [(1.0, 9 * 0.125), (0.5, 5 * 0.125), (0.0, 4.0)])
def test_a_robot_stops_when_commands_stop(stepped, robot_with, cmd_vel, timeout, way):
    robot = robot_with(cmd_timeout=timeout)
    publisher = cmd_vel()
    stepped.step()
    publisher.publish(twist_stamped(1.0, 0.0))
    stepped.step(32)

    assert robot.state[0, 0] == way  # the first step with the command is one of those that move
    assert robot.state[3, 0] == (1.0 if timeout == 0.0 else 0.0)


def test_the_newest_of_several_commands_counts(stepped, robot_with, cmd_vel):
    robot = robot_with()
    publisher = cmd_vel()
    stepped.step()
    for speed in (0.1, 0.2, 0.3):
        publisher.publish(twist_stamped(speed, 0.0))
    stepped.step()

    assert robot.state[3, 0] == 0.3


def test_commands_of_the_other_type_are_taken_if_asked_for(stepped, robot_with, cmd_vel):
    robot = robot_with(cmd_vel_type='twist')
    publisher = cmd_vel(Twist)
    stepped.step()
    publisher.publish(twist_stamped(0.3, -0.5).twist)
    stepped.step()

    assert robot.state[3:, 0].tolist() == [0.3, 0.0, -0.5]


def test_a_command_has_a_speed_to_the_left(stepped, robot_with, cmd_vel):
    robot = robot_with()
    publisher = cmd_vel()
    stepped.step()
    message = twist_stamped(0.1, -0.2)
    message.twist.linear.y, message.twist.linear.z = 0.5, 9.0
    publisher.publish(message)
    stepped.step()

    assert robot.command[:, 0].tolist() == [0.1, 0.5, -0.2]


def test_a_reset_puts_the_robot_back_where_it_rests(peer, stepped, robot_with, cmd_vel):
    robot = robot_with('x0:=2.0')
    reset, command = peer.publisher(Empty, '/tb3_3/reset'), cmd_vel()
    stepped.step()
    command.publish(twist_stamped(0.5, 0.5))
    stepped.step(3)
    assert robot.state[0, 0] > 2.0
    reset.publish(Empty())
    stepped.step(3)

    assert robot.state[:, 0].tolist() == [2.0, 0.0, 0.0, 0.0, 0.0, 0.0]


def test_a_command_from_before_a_restart_is_not_followed_after_it(stepped, robot_with, cmd_vel):
    robot = robot_with('x0:=2.0')
    command = cmd_vel()
    stepped.step()
    command.publish(twist_stamped(0.5, 0.5))
    robot.restart()
    stepped.step(3)
    assert robot.state[:, 0].tolist() == [2.0, 0.0, 0.0, 0.0, 0.0, 0.0]

    command.publish(twist_stamped(0.5, 0.5))
    stepped.step()
    assert robot.state[3, 0] == 0.5


def test_a_command_that_no_robot_can_follow_stops_it_and_is_named_once(
    stepped, robot_with, cmd_vel, capfd
):
    robot = robot_with()
    publisher = cmd_vel()
    stepped.step()
    for V in (math.nan, math.inf, 1e308, math.nan):
        publisher.publish(twist_stamped(0.5, 0.0))
        stepped.step()
        assert robot.state[3, 0] == 0.5
        publisher.publish(twist_stamped(V, 0.0))
        stepped.step()
        assert robot.state[3, 0] == 0.0

    assert np.isfinite(robot.state).all()
    said = capfd.readouterr().err
    assert said.count('tb3_3 stops: its command on cmd_vel is nan, 0 m/s, 0 rad/s') == 1
    assert said.count('tb3_3 stops') == 1


def test_a_command_that_its_sender_cut_short_is_left_out(stepped, robot_with, cmd_vel):
    robot = robot_with()
    publisher = cmd_vel()
    stepped.step()
    publisher.publish(twist_stamped(0.5, 0.0))
    stepped.step()
    for size in (40, 14):
        publisher.publish(serialize_message(twist_stamped(0.2, 0.0))[:size])
        stepped.step()
        assert robot.state[3, 0] == 0.5


def test_parameters_can_be_set_while_it_runs(stepped, robot_with, cmd_vel):
    robot = robot_with()
    publisher = cmd_vel()
    stepped.step()

    def speed_after(**parameter):
        ((name, value),) = parameter.items()
        (answer,) = robot.set_parameters([Parameter(name, value=value)])
        assert answer.successful
        publisher.publish(twist_stamped(1.0, 0.0))
        stepped.step(5)
        return robot.state[3, 0]

    assert speed_after(limits='burger') == pytest.approx(0.2108, abs=0.01)
    assert speed_after(limits='ideal') == 1.0
    assert speed_after(cmd_timeout=0.5) == 1.0
    assert speed_after(cmd_timeout=0.3) == 0.0
    (answer,) = robot.set_parameters([Parameter('cmd_timeout', value=0.1)])
    assert 'it must be at least 0.3 s' in answer.reason
    (answer,) = robot.set_parameters([Parameter('x0', value=1.0)])
    assert 'read-only' in answer.reason


def test_robots_with_limits_of_their_own_take_no_others(robot_with):
    robot = robot_with('model:=car')

    (answer,) = robot.set_parameters([Parameter('limits', value='burger')])
    assert not answer.successful
    assert 'car' in answer.reason


@pytest.mark.parametrize(
    ('given', 'message'),
    [
        ('x0:=here', 'x0'),
        ('theta0:=.nan', 'theta0'),
        ('x0:=1.0e9', 'x0'),
        ('model:=segway', "unknown robot model 'segway'"),
        ('limits:=segway', 'limits'),
        ('robot_no:=0', 'parameter robot_no is 0; it must be a number from 1'),
        ('use_sim_time:=true', 'virtual_robot refuses use_sim_time'),
    ],
)
def test_parameters_that_make_no_sense_are_refused(robot_with, given, message):
    with pytest.raises(SetcmasError, match=message):
        robot_with(given)


def test_what_displays_need_is_published_while_one_subscribes(peer, stepped, robot_with):
    robot_with('x0:=1.0', 'frame_id:=map')
    odometry = peer.listen(Odometry, '/tb3_3/odom')
    stepped.step(4)
    poses = peer.listen(PoseStamped, '/tb3_3/pose')
    stepped.step()  # it looks for displays twice a second
    peer.wait_for(lambda: poses and len(odometry) == 5)

    assert len(poses) == 1
    assert poses[0].pose.position.x == 1.0
    assert poses[0].header.frame_id == 'map'


def test_a_robot_script_that_fails_is_reported_once_and_the_robot_stays(
    peer, stepped, cmd_vel, tmp_path, capfd
):
    script = tmp_path / 'frozen.py'
    script.write_text('def step(state, command, Ts):\n    return 1 / 0\n')
    failures = []
    of_node = stepped.arguments(peer, '-r', '__ns:=/tb3_3')
    robot = peer.add(VirtualRobot(model=str(script), on_failure=failures.append, **of_node))
    stepped.nodes = [robot]
    publisher = cmd_vel()
    stepped.step()
    publisher.publish(twist_stamped(0.5, 0.0))
    stepped.step(5)

    assert robot.state[:3, 0].tolist() == [0.0, 0.0, 0.0]
    assert [failure.call.robot for failure in failures] == [3]
    assert capfd.readouterr().err.count('ZeroDivisionError') == 1
