import signal
import sys

import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from ros_peer import Peer, twist, twist_stamped, velocity

GUARD = [sys.executable, '-m', 'setcmas_expe.safety.cmd_vel_guard']
NAMESPACE = ['--ros-args', '-r', '__ns:=/tb3_1']


@pytest.mark.parametrize(('kind', 'command'), [(TwistStamped, twist_stamped), (Twist, twist)])
def test_a_robot_is_stopped_when_its_commands_end(start, peer, kind, command):
    heard = peer.cmd_vel(1, kind)  # the robot itself
    process = start(*GUARD, *NAMESPACE)
    publisher = peer.publisher(kind, '/tb3_1/cmd_vel', listeners=2)
    process.wait_for_output('guarding /tb3_1/cmd_vel')

    publisher.publish(command(0.1, 0.5))
    peer.wait_for(lambda: command(0.1, 0.5) in heard)
    peer.wait_for(lambda: heard[-1] == command(0.0, 0.0))
    process.wait_for_output('commands have ended: stopping the robot')
    peer.wait_for_new(heard, 3)  # repeated, in case one is lost

    publisher.publish(command(0.2, 0.0))  # whoever commands again is not held back
    peer.wait_for(lambda: heard[-1] == command(0.2, 0.0))
    process.popen.send_signal(signal.SIGTERM)  # nor left without a stop when the guard ends
    peer.wait_for(lambda: heard[-1] == command(0.0, 0.0))
    assert process.wait() == 0


def test_a_robot_that_was_stopped_by_others_is_left_alone(start, peer):
    heard = peer.cmd_vel(1)
    process = start(*GUARD, *NAMESPACE)
    publisher = peer.publisher(TwistStamped, '/tb3_1/cmd_vel', listeners=2)
    process.wait_for_output('guarding')
    publisher.publish(twist_stamped(0.1, 0.0))
    publisher.publish(twist_stamped(0.0, 0.0))
    peer.wait_for(lambda: twist_stamped(0.1, 0.0) in heard)
    peer.spin(0.6)

    assert heard[-1] == twist_stamped(0.0, 0.0)
    assert 'ended' not in process.output()


def test_a_robot_that_moves_already_is_stopped_though_nothing_is_heard_of_its_commands(
    start, peer
):
    """Of a laptop that died while the guard was not there."""
    heard = peer.cmd_vel(1)
    process = start(*GUARD, *NAMESPACE)
    peer.wait_for_new(heard, 3)

    assert set(map(velocity, heard)) == {(0.0, 0.0)}
    assert 'ended' not in process.output()


def test_the_type_is_that_of_the_robot_and_not_of_somebody_who_looks_on(start, peer, domain):
    with Peer(domain) as other:  # a process of its own, as DDS sees it
        looks_on = Node('looks_on', context=other.context)
        looks_on.create_subscription(TwistStamped, '/tb3_1/cmd_vel', print, 1)
        heard = peer.cmd_vel(1, Twist)
        wheels = Node('diff_drive_controller', context=peer.context)  # as on TurtleBot3s
        wheels.create_publisher(Odometry, '/tb3_1/odom', 10)
        process = start(*GUARD, *NAMESPACE)
        process.wait_for_output('guarding /tb3_1/cmd_vel (twist)')
        publisher = peer.publisher(Twist, '/tb3_1/cmd_vel', listeners=2)
        publisher.publish(twist(0.1, 0.0))
        peer.wait_for(lambda: twist(0.1, 0.0) in heard and heard[-1] == twist(0.0, 0.0))
        looks_on.destroy_node()
        wheels.destroy_node()
