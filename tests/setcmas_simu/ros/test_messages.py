import math

import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from processes import SIMU
from rclpy.duration import Duration

from setcmas_simu.ros import messages, qos
from setcmas_simu.ros.messages import state_of, wait_until_received


def odometry(x, y, z, w):
    message = Odometry()
    message.pose.pose.position.x, message.pose.pose.position.y = x, y
    message.pose.pose.orientation.z, message.pose.pose.orientation.w = z, w
    message.twist.twist.linear.x = 0.3
    return message


@pytest.mark.parametrize('length', [1.0, 0.5], ids=['unit', 'not normalised'])
def test_the_state_in_an_odometry(length):
    z, w = length * math.sin(1.0), length * math.cos(1.0)
    message = odometry(1.0, -2.0, z, w)
    state = state_of(message)

    assert state.pose == pytest.approx((1.0, -2.0, 2.0))
    assert state.V == 0.3
    assert state.odometry is message


@pytest.mark.parametrize(
    ('values', 'message'),
    [
        ((math.nan, 0.0, 0.0, 1.0), 'its pose is NaN or infinite'),
        ((0.0, -math.inf, 0.0, 1.0), 'its pose is NaN or infinite'),
        ((0.0, 0.0, math.nan, 1.0), 'its pose is NaN or infinite'),
        ((0.0, 0.0, 1e200, 1.0), 'its pose is NaN or infinite'),
        ((0.0, 0.0, 0.0, 0.0), 'its orientation is a zero quaternion'),
    ],
)
def test_an_odometry_without_a_usable_pose_says_why(values, message):
    assert state_of(odometry(*values)) == message


def test_a_stamp_has_whole_seconds_and_nanoseconds():
    stamp = messages.stamp_of(7_000_000_008)

    assert (stamp.sec, stamp.nanosec) == (7, 8)


def test_last_commands_have_been_received_when_the_wait_ends(start, peer):
    start(*SIMU, '--nb-robots', '1').wait_for_output('simulating')
    publisher = peer.node.create_publisher(TwistStamped, '/tb3_1/cmd_vel', qos.COMMAND)
    peer.wait_for(publisher.get_subscription_count)

    for _ in range(6):
        publisher.publish(TwistStamped())
        wait_until_received([publisher])
        assert publisher.wait_for_all_acked(Duration(seconds=0))
