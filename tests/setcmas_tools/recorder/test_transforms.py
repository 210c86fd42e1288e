import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from setcmas_tools.recorder.transforms import base_link_of, tf_message, transform_of

STORE = get_typestore(Stores.ROS2_JAZZY)
CLASSES = {name.rpartition('/')[2]: kind for name, kind in STORE.types.items()}
POSITION = (1.5, -2.0, 0.25)
QUATERNION = (0.1, 0.2, 0.3, 0.9)


def make(kind, *fields):
    return CLASSES[kind](*fields)


def odometry(child, parent='world'):
    """Return an odometry in CDR, as another implementation writes it."""
    pose = make('Pose', make('Point', *POSITION), make('Quaternion', *QUATERNION))
    twist = make('Twist', make('Vector3', 0, 0, 0), make('Vector3', 0, 0, 0))
    message = make(
        'Odometry',
        make('Header', make('Time', 12, 34), parent),
        child,
        make('PoseWithCovariance', pose, np.zeros(36)),
        make('TwistWithCovariance', twist, np.zeros(36)),
    )
    return bytes(STORE.serialize_cdr(message, 'nav_msgs/msg/Odometry'))


def read(data):
    return STORE.deserialize_cdr(data, 'tf2_msgs/msg/TFMessage').transforms


@pytest.mark.parametrize(
    'children', [('tb3_1/base_footprint', 'tb3_10/base_footprint'), 'abcdefgh']
)
def test_the_poses_of_odometry_are_read_as_transforms(children):
    transforms = read(tf_message([transform_of(odometry(child)) for child in children]))

    assert [one.child_frame_id for one in transforms] == list(children)
    for one in transforms:
        place, turn = one.transform.translation, one.transform.rotation
        assert one.header.frame_id == 'world'
        assert (one.header.stamp.sec, one.header.stamp.nanosec) == (12, 34)
        assert (place.x, place.y, place.z) == POSITION
        assert (turn.x, turn.y, turn.z, turn.w) == QUATERNION


@pytest.mark.parametrize(
    'data',
    [
        pytest.param(odometry('base_footprint', parent='odom'), id='wheels'),
        pytest.param(odometry('tb3_1/base_footprint')[:90], id='cut short'),
        pytest.param(b'\0\0' + odometry('tb3_1/base_footprint')[2:], id='big endian'),
        pytest.param(b'', id='empty'),
        pytest.param(odometry(''), id='no child'),
    ],
)
def test_what_is_no_pose_in_the_world_is_left_out(data):
    assert transform_of(data) is None


def test_base_link_stands_above_the_base_footprint():
    (link,) = read(tf_message([base_link_of(transform_of(odometry('tb3_3/base_footprint')))]))

    assert (link.header.frame_id, link.child_frame_id) == (
        'tb3_3/base_footprint',
        'tb3_3/base_link',
    )
    assert (link.transform.translation.z, link.transform.rotation.w) == (0.01, 1.0)
    assert base_link_of(transform_of(odometry('tb3_3'))) is None
