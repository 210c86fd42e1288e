import math

import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from processes import SIMU
from rclpy.duration import Duration
from rclpy.serialization import serialize_message
from rosbags.typesys import Stores, get_typestore

from setcmas_simu.ros import messages, qos
from setcmas_simu.ros.messages import (
    CutShortError,
    SerializedMessage,
    fill_odometry,
    state_in,
    state_of,
    wait_until_received,
)


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
    assert state_in(serialize_message(message)) == state


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


def odometry_of(frame, child):
    message = Odometry(child_frame_id=child)
    message.header.frame_id = frame
    message.header.stamp.sec, message.header.stamp.nanosec = 3, 5
    fill_odometry(message, (1.5, -2.25, 0.7), 0.125, -0.5)
    message.pose.covariance[:], message.twist.covariance[:] = 7.0, 8.0
    return message


@pytest.mark.parametrize('child', ['', 'b', 'ba', 'base', 'tb3_12/base_link', 'é'])
@pytest.mark.parametrize('frame', ['', 'w', 'wo', 'wor', 'world'])
def test_the_state_is_read_whatever_the_names_of_frames(frame, child):
    message = odometry_of(frame, child)
    state = state_in(serialize_message(message))
    assert state == state_of(message)
    assert state.pose[:2] == (1.5, -2.25)
    assert state.V == 0.125


def test_big_endian_messages_are_read():
    store = get_typestore(Stores.ROS2_JAZZY)
    kind = 'nav_msgs/msg/Odometry'
    message = store.deserialize_cdr(serialize_message(odometry_of('world', 'base')), kind)
    data = bytes(store.serialize_cdr(message, kind, little_endian=False))
    assert data[:2] == b'\x00\x00'
    assert state_in(data) == state_of(odometry_of('world', 'base'))


def test_a_message_that_ends_early_has_no_state():
    data = serialize_message(odometry_of('world', 'base'))
    assert {state_in(data[:size]) for size in range(len(data))} == {'it is cut short'}


def test_a_name_longer_than_its_message_is_cut_short():
    data = bytearray(serialize_message(TwistStamped()))
    data[12:16] = b'\xff\xff\xff\xff'
    fields = SerializedMessage(bytes(data))
    fields.skip_header()
    with pytest.raises(CutShortError):
        fields.reals(6)


def test_unknown_encodings_are_refused():
    with pytest.raises(CutShortError):
        SerializedMessage(b'\x00\x07' + serialize_message(TwistStamped())[2:])
