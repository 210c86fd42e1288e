import struct
import zlib

import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message, serialize_message

from setcmas_simu.ros.messages import (
    LocatedMessage,
    decode_forms,
    encode_forms,
    read_odometry,
    read_twist,
)

FRAMES = ['', 'w', 'map', 'world', 'a_longer_frame']


def odometry(frame, child):
    message = Odometry(child_frame_id=child)
    message.header.frame_id = frame
    message.pose.covariance[0] = 0.5
    return message


@pytest.mark.parametrize('frame', FRAMES)
@pytest.mark.parametrize('child', FRAMES)
def test_what_is_written_into_the_bytes_is_read_from_the_message(frame, child):
    form = LocatedMessage.of(odometry(frame, child), 'pose.pose', 'twist.twist')
    form = decode_forms(encode_forms({'/tb3_1/odom': form}))['/tb3_1/odom']
    data = form.at(7_000_000_008, (1.0, 2.0, 0.3, 0.4, 4.0, 5.0, 6.0))
    message = deserialize_message(data, Odometry)

    position, q = message.pose.pose.position, message.pose.pose.orientation
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (7, 8)
    assert (message.header.frame_id, message.child_frame_id) == (frame, child)
    assert (position.x, position.y, position.z) == (1.0, 2.0, 0.0)
    assert (q.x, q.y, q.z, q.w) == (0.0, 0.0, 0.3, 0.4)
    assert message.pose.covariance[0] == 0.5
    twist = message.twist.twist
    assert (twist.linear.x, twist.linear.y, twist.angular.z) == (4.0, 5.0, 6.0)
    assert read_odometry(data) == ((1.0, 2.0), (0.0, 0.0, 0.3, 0.4), 4.0, 6.0)


def test_data_without_forms_are_refused():
    outside = b'{"/tb3_1/odom": ["00", 0, 8, null]}'
    endless = b'{"a": "' + bytes(2**24)
    far = b'{"/tb3_1/odom": ["00", %d, 8, null]}' % 10**30
    nested = b'[' * 10**5
    for text in (b'', b'[]', b'{}', b'{"a": 1}', outside, far, nested, endless):
        with pytest.raises(ValueError, match=r'.'):
            decode_forms(zlib.compress(text))
    for data in (b'', b'no'):
        with pytest.raises(ValueError, match=r'.'):
            decode_forms(data)


@pytest.mark.parametrize('frame', FRAMES)
def test_commands_of_both_types_are_read(frame):
    twist = Twist()
    twist.linear.x, twist.linear.y, twist.angular.z = 0.1, 0.2, 0.3
    stamped = TwistStamped(twist=twist)
    stamped.header.frame_id = frame

    assert read_twist(serialize_message(twist), Twist) == (0.1, 0.2, 0.3)
    assert read_twist(serialize_message(stamped), TwistStamped) == (0.1, 0.2, 0.3)


def test_a_message_of_a_machine_with_the_other_byte_order_is_read():
    little = serialize_message(Twist())
    numbers = [0.1, 0.2, 0.0, 0.0, 0.0, 0.3]
    big = b'\x00\x00' + little[2:4] + struct.pack('>6d', *numbers)
    assert read_twist(big, Twist) == (0.1, 0.2, 0.3)
