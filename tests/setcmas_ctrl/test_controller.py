import signal
import textwrap

import numpy as np
import pytest
from processes import CTRL, SIMU

pytest.importorskip('rclpy')

from geometry_msgs.msg import Point32, Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_peer import position
from std_msgs.msg import Bool
from visualization_msgs.msg import Marker, MarkerArray


@pytest.fixture
def script(tmp_path):
    def write(text, name='law.py'):
        path = tmp_path / name
        path.write_text(textwrap.dedent(text))
        return str(path)

    return write


def velocity(message):
    return message.twist.linear.x, message.twist.angular.z


def test_consensus_over_the_topics(start, peer):
    start(*SIMU, '--nb-robots', '3', '--pose', '1:0,0', '--pose', '2:1,0', '--pose', '3:0.5,1')
    odometry = [peer.odometry(robot) for robot in (1, 2, 3)]
    process = start(*CTRL, '--algo', 'consensus')
    process.wait_for_output('controlling robots 1-3 with consensus at 5 Hz')

    def spread():
        return np.ptp([position(messages[-1]) for messages in odometry], axis=0).max()

    peer.wait_for(lambda: all(odometry) and spread() < 0.3)
    assert process.end() == 0


def test_the_law_sees_number_fleet_poses_and_time(start, peer, script):
    law = script(
        """
        def control(robotNo, nbRobots, poses, t):
            assert poses.shape == (3, nbRobots)
            return 0.1 * robotNo, 0.01 * poses[2, 1]
        """
    )
    start(*SIMU, '--nb-robots', '2', '--pose', '2:0,0,1.5')
    wanted = [peer.cmd_cart_vel(robot) for robot in (1, 2)]
    start(*CTRL, '--algo', law)
    peer.wait_for(lambda: all(wanted))

    assert (wanted[0][0].x, wanted[0][0].y) == pytest.approx((0.1, 0.015))
    assert (wanted[1][0].x, wanted[1][0].y) == pytest.approx((0.2, 0.015))


def test_velocities_are_saturated_and_turned_into_commands(start, peer, script):
    law = script('def control(i, n, p, t):\n    return 0, 30\n')
    start(*SIMU, '--nb-robots', '1')
    wanted, command = peer.cmd_cart_vel(1), peer.cmd_vel(1)
    start(*CTRL, '--algo', law, '--vnom', '0.2', '--komega', '0.5')
    peer.wait_for(lambda: wanted and command)

    assert (wanted[0].x, wanted[0].y) == pytest.approx((0.0, 0.2))
    assert velocity(command[0]) == pytest.approx((0.2, 0.5 * np.pi / 2))


def test_a_part_of_the_fleet_is_controlled_with_the_poses_of_all(start, peer):
    start(*SIMU, '--nb-robots', '4')
    commands = [peer.cmd_vel(robot) for robot in (1, 2, 3, 4)]
    start(*CTRL, '--algo', 'consensus', '--robots', '2-3').wait_for_output(
        'controlling robots 2-3'
    )
    peer.wait_for(lambda: len(commands[1]) > 3 and len(commands[2]) > 3)

    assert not commands[0]
    assert not commands[3]


def test_a_robot_that_listens_to_plain_twist_gets_it(start, peer):
    start(*SIMU, '--nb-robots', '1', '--pose', '1:3,3', '--cmd-vel-type', 'twist')
    odometry = peer.odometry(1)
    start(*CTRL, '--algo', 'nav_wp')

    peer.wait_for(lambda: odometry and odometry[-1].twist.twist.linear.x > 0.1)


def test_the_robot_decides_the_type_when_others_listen_too(start, peer):
    peer.cmd_vel(1, TwistStamped)
    start(*SIMU, '--nb-robots', '1', '--pose', '1:3,3', '--cmd-vel-type', 'twist')
    odometry = peer.odometry(1)
    process = start(*CTRL, '--algo', 'nav_wp')

    peer.wait_for(lambda: odometry and odometry[-1].twist.twist.linear.x > 0.1)
    process.wait_for_output('tb3_1 gets twist, but peer wants twist_stamped')


def test_a_slow_fleet_is_told_so_and_not_that_its_odometry_is_lost(start, script):
    law = script('import time\ndef control(i, n, p, t):\n    time.sleep(0.3)\n    return 0, 0\n')
    start(*SIMU, '--nb-robots', '5')
    process = start(*CTRL, '--algo', law)

    process.wait_for_output('longer than the control period of 0.20 s')
    process.wait_for_output('s for 5 robots')
    assert 'no odometry' not in process.output()


def test_robots_that_come_later_are_mentioned(start):
    start(*SIMU, '--nb-robots', '4', '--robots', '1-2').wait_for_output('simulating')
    process = start(*CTRL, '--algo', 'consensus')
    process.wait_for_output('controlling robots 1-2')
    start(*SIMU, '--nb-robots', '4', '--robots', '3-4')

    process.wait_for_output('have appeared; this controller does not know them')


def test_a_wanted_velocity_that_is_not_finite_becomes_zero(start, peer, script):
    law = script('def control(i, n, p, t):\n    return 0.3, 0\n')
    start(*SIMU, '--nb-robots', '1').wait_for_output('simulating')
    start(*CTRL, '--algo', law).wait_for_output('controlling')
    wanted, command = peer.publisher(Point32, '/tb3_1/cmd_cart_vel'), peer.cmd_vel(1)
    peer.wait_for(lambda: command)
    wanted.publish(Point32(x=float('nan')))

    peer.wait_for(lambda: any(velocity(m) == (0.0, 0.0) for m in command))
    assert np.isfinite([velocity(m) for m in command]).all()


def test_a_script_with_a_thread_of_its_own_ends_too(start, script):
    law = script(
        """
        import threading, time
        threading.Thread(target=time.sleep, args=(600,)).start()
        def control(robotNo, nbRobots, poses, t):
            return 0, 0
        """
    )
    start(*SIMU, '--nb-robots', '1')
    process = start(*CTRL, '--algo', law)
    process.wait_for_output('controlling')

    assert process.end() == 0


def test_it_says_when_nothing_listens_to_the_commands(start, peer):
    publisher = peer.node.create_publisher(Odometry, '/tb3_1/odom', 10)
    peer.node.create_timer(0.1, lambda: publisher.publish(Odometry()))
    process = start(*CTRL, '--algo', 'nav_wp', '--nb-robots', '1')

    peer.wait_for(lambda: 'nothing listens to cmd_vel of robots 1' in process.output())


def test_it_says_which_odometry_it_waits_for(start, peer):
    start(*SIMU, '--nb-robots', '4', '--robots', '1,4')
    process = start(*CTRL, '--algo', 'consensus', '--nb-robots', '4')

    process.wait_for_output('waiting for the odometry of robots 2-3')


def test_it_says_that_it_waits_for_a_fleet_and_goes_on_when_there_is_one(start):
    process = start(*CTRL, '--algo', 'consensus')
    process.wait_for_output('waiting for a fleet')
    start(*SIMU, '--nb-robots', '2')

    process.wait_for_output('controlling robots 1-2')


def test_pause_holds_one_robot_or_the_fleet_at_zero(start, peer):
    start(*SIMU, '--nb-robots', '2')
    commands = [peer.cmd_vel(robot) for robot in (1, 2)]
    start(*CTRL, '--algo', 'consensus').wait_for_output('controlling')
    pause_first = peer.publisher(Bool, '/tb3_1/pause')
    pause_all = peer.publisher(Bool, '/pause')

    def stands(index):
        return all(velocity(m) == (0.0, 0.0) for m in commands[index][-3:])

    peer.wait_for(lambda: all(commands))
    pause_first.publish(Bool(data=True))
    peer.wait_for(lambda: stands(0) and not stands(1))
    pause_all.publish(Bool(data=True))
    peer.wait_for(lambda: stands(0) and stands(1))
    pause_all.publish(Bool(data=False))
    peer.wait_for(lambda: not stands(0) and not stands(1))


@pytest.mark.parametrize('signum', [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_the_last_command_is_zero(start, peer, script, signum):
    law = script('def control(i, n, p, t):\n    return 0.3, 0\n')
    start(*SIMU, '--nb-robots', '3')
    odometry = [peer.odometry(robot) for robot in (1, 2, 3)]
    process = start(*CTRL, '--algo', law)
    peer.wait_for(lambda: all(o and o[-1].twist.twist.linear.x > 0.2 for o in odometry))

    process.popen.send_signal(signum)

    peer.wait_for(lambda: all(o[-1].twist.twist.linear.x == 0.0 for o in odometry))
    assert process.wait() == 0
    assert 'Traceback' not in process.output()


def test_a_failing_robot_stands_while_the_others_go_on(start, peer, script):
    law = script(
        """
        def control(robotNo, nbRobots, poses, t):
            if robotNo == 2:
                return poses[0, 99], 0
            return 0.2, 0
        """
    )
    start(*SIMU, '--nb-robots', '3')
    odometry = [peer.odometry(robot) for robot in (1, 2, 3)]
    process = start(*CTRL, '--algo', law)
    peer.wait_for(lambda: all(odometry) and odometry[2][-1].twist.twist.linear.x > 0.1)
    start_of_second = position(odometry[1][0])
    peer.wait_for_new(odometry[1], 20)

    assert position(odometry[1][-1]) == start_of_second
    assert position(odometry[0][-1]) != position(odometry[0][0])
    output = process.output()
    assert output.count('IndexError') == 1
    assert 'tb3_2 at t = 0.0 s: law.py, line 4: IndexError' in output
    assert '4 | return poses[0, 99], 0' in output
    assert process.end() == 1


def test_a_script_that_raises_keyboard_interrupt_stops_its_own_robot_only(start, peer, script):
    law = script(
        """
        def control(robotNo, nbRobots, poses, t):
            if robotNo == 1:
                raise KeyboardInterrupt
            return 0.2, 0
        """
    )
    start(*SIMU, '--nb-robots', '2')
    command = peer.cmd_vel(2)
    process = start(*CTRL, '--algo', law)
    peer.wait_for(lambda: len(command) > 5 and velocity(command[-1])[0] > 0.1)

    assert 'law.py, line 4: KeyboardInterrupt' in process.output()


def test_a_stuck_script_is_located_and_no_command_is_sent_meanwhile(start, peer, script):
    law = script(
        """
        def control(robotNo, nbRobots, poses, t):
            while t > 1:
                pass  # for ever
            return 0.2, 0
        """
    )
    start(*SIMU, '--nb-robots', '2', '--cmd-timeout', '0.6')
    odometry, command = peer.odometry(1), peer.cmd_vel(1)
    process = start(*CTRL, '--algo', law)
    peer.wait_for(lambda: 'has not returned' in process.output())

    sent = len(command)
    assert 'law.py, line ' in process.output()
    peer.wait_for(lambda: odometry[-1].twist.twist.linear.x == 0.0)
    assert len(command) == sent
    assert process.end() == 0


def test_a_stuck_script_that_swallows_every_exception_still_ends(start, peer, script):
    law = script(
        """
        def control(robotNo, nbRobots, poses, t):
            while True:
                try:
                    while True:
                        pass
                except BaseException:
                    pass
        """
    )
    start(*SIMU, '--nb-robots', '1')
    command = peer.cmd_vel(1)
    process = start(*CTRL, '--algo', law)
    process.wait_for_output('has not returned')
    process.popen.send_signal(signal.SIGINT)
    process.popen.send_signal(signal.SIGTERM)

    peer.wait_for(lambda: command and velocity(command[-1]) == (0.0, 0.0))
    assert process.wait() != 0


def test_a_robot_whose_odometry_ends_is_commanded_zero(start, peer, script):
    law = script('def control(i, n, p, t):\n    return 0.3, 0\n')
    first = start(*SIMU, '--nb-robots', '2', '--robots', '1')
    start(*SIMU, '--nb-robots', '2', '--robots', '2')
    commands = [peer.cmd_vel(robot) for robot in (1, 2)]
    process = start(*CTRL, '--algo', law, '--nb-robots', '2')
    peer.wait_for(lambda: all(commands))
    first.end(signal.SIGKILL)

    peer.wait_for(lambda: velocity(commands[0][-1]) == (0.0, 0.0))
    assert 'tb3_1: no odometry for' in process.output()
    peer.wait_for_new(commands[1], 2)
    assert velocity(commands[1][-1])[0] == pytest.approx(0.3)


def test_a_second_controller_of_a_robot_is_noticed(start):
    start(*SIMU, '--nb-robots', '1').wait_for_output('simulating')
    first = start(*CTRL, '--algo', 'nav_wp')
    first.wait_for_output('controlling')
    start(*CTRL, '--algo', 'nav_wp')

    first.wait_for_output('another controller commands robots 1 too (/tb3_1/si_to_uni)')


def test_drawings_are_seen_even_by_a_display_that_comes_late(start, peer):
    start(*SIMU, '--nb-robots', '1', '--pose', '1:2,0')
    process = start(*CTRL, '--algo', 'traj_tracking')
    process.wait_for_output('controlling')
    wanted = peer.cmd_cart_vel(1)
    peer.wait_for(lambda: len(wanted) > 10)
    late = QoSProfile(depth=500, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    trail = peer.listen(MarkerArray, '/tb3_1/traj_ref', late)
    peer.wait_for(lambda: len(trail) > 8)

    markers = [message.markers for message in trail]
    assert {len(m) for m in markers} == {1}
    assert len({m[0].id for m in markers}) == len(markers)
    assert markers[0][0].scale.x == pytest.approx(0.1)
    assert markers[0][0].color.b == 0.0


def test_one_name_may_serve_a_marker_and_a_trail(start, peer, script):
    law = script(
        """
        import rviz_marker, rviz_marker_array
        def control(robotNo, nbRobots, poses, t):
            rviz_marker.publish_marker(1, 2, 0, robotNo)
            rviz_marker_array.publish_marker(3, 4, 0, robotNo)
            return 0, 0
        """
    )
    start(*SIMU, '--nb-robots', '1')
    start(*CTRL, '--algo', law)
    marker = peer.listen(Marker, '/tb3_1/ref')
    trail = peer.listen(MarkerArray, '/tb3_1/ref_markerarray')

    peer.wait_for(lambda: marker and trail)


def test_the_waypoint_is_drawn(start, peer):
    start(*SIMU, '--nb-robots', '1')
    start(*CTRL, '--algo', 'nav_wp')
    drawn = peer.listen(Marker, '/tb3_1/wp_ref')
    peer.wait_for(lambda: drawn)

    assert (drawn[0].pose.position.x, drawn[0].pose.position.y) == (2.0, 2.0)
    assert drawn[0].scale.x == pytest.approx(0.3)


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('x = 1\n', 'no function control'),
        ('def control(a, b):\n    return 0, 0\n', 'does not take four arguments'),
        ('1 / 0\ndef control(a, b, c, d):\n    return 0, 0\n', 'line 1: ZeroDivisionError'),
    ],
)
def test_scripts_that_cannot_be_loaded_are_told(start, script, text, message):
    start(*SIMU, '--nb-robots', '1')
    process = start(*CTRL, '--algo', script(text))

    assert process.wait() == 2
    assert message in process.output()
    assert 'Traceback' not in process.output()


def test_other_publishers_of_the_wanted_velocity_are_served(start, peer):
    start(*SIMU, '--nb-robots', '1').wait_for_output('simulating')
    start(*CTRL, '--algo', 'consensus').wait_for_output('controlling')
    wanted = peer.publisher(Point32, '/tb3_1/cmd_cart_vel')
    command = peer.cmd_vel(1)
    peer.wait_for(lambda: command)
    wanted.publish(Point32(x=0.25))

    peer.wait_for(lambda: any(velocity(m)[0] == 0.25 for m in command))


def test_the_type_of_the_commands_can_be_forced(start, peer):
    start(*SIMU, '--nb-robots', '1').wait_for_output('simulating')
    plain = peer.cmd_vel(1, Twist)
    process = start(*CTRL, '--algo', 'nav_wp', '--cmd-vel-type', 'twist')

    process.wait_for_output('controlling')
    peer.wait_for(lambda: plain)
