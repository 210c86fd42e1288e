import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import ReaderError
from rosbags.typesys import Stores, get_typestore

from setcmas_simu.errors import SetcmasError
from setcmas_tools.bags.bag import open_bag
from setcmas_tools.bags.bag_writer import BagWriter, TransformRecorder
from setcmas_tools.bags.message_types import MessageDefinitions

POINT = 'geometry_msgs/msg/Point32'
ZERO = QosTime(0, 0)
LATCHED = Qos(
    QosHistory.UNKNOWN,
    0,
    QosReliability.RELIABLE,
    QosDurability.TRANSIENT_LOCAL,
    ZERO,
    ZERO,
    QosLiveliness.AUTOMATIC,
    ZERO,
    avoid_ros_namespace_conventions=False,
)


@pytest.fixture
def data(store, make):
    """Serialised points with x = 0, 1, 2, ..."""
    points = [make(POINT, {'x': float(i)}) for i in range(50)]
    return [bytes(store.serialize_cdr(point, POINT)) for point in points]


def add_points(writer):
    return writer.add_topic('/points', POINT, MessageDefinitions([]).of(POINT), [LATCHED])


def count(path):
    with open_bag(path) as bag:
        return len(list(bag.messages()))


def test_closed_bag_is_read_by_others(tmp_path, data):
    with BagWriter(tmp_path / 'bag') as writer:
        topic = add_points(writer)
        for i, message in enumerate(data):
            writer.write(topic, 10**9 + i * 10**8, message)
            if i % 20 == 0:
                writer.flush()
    assert str(writer) == '50 messages of 1 topic in 4.9 s'
    with AnyReader([tmp_path / 'bag']) as reader:
        read = [(t, reader.deserialize(d, c.msgtype).x) for c, t, d in reader.messages()]
        assert reader.connections[0].ext.offered_qos_profiles == [LATCHED]
    assert read == [(10**9 + i * 10**8, float(i)) for i in range(50)]
    with (tmp_path / 'bag' / 'bag.mcap').open('rb') as stream:
        messages = list(make_reader(stream, validate_crcs=True).iter_messages())
    assert [bytes(message.data) for _, _, message in messages] == data


@pytest.mark.parametrize('lost', [range(20), range(20, 40)])
def test_one_flipped_bit_is_found(tmp_path, data, lost):
    with BagWriter(tmp_path / 'bag') as writer:
        topic = add_points(writer)
        for i, message in enumerate(data):
            writer.write(topic, 10**9 + i * 10**8, message)
            if i in (19, 39):
                writer.flush()
    path = tmp_path / 'bag' / 'bag.mcap'
    content = bytearray(path.read_bytes())
    content[content.index(data[lost[5]]) + 6] ^= 0x40  # in the exponent of x
    path.write_bytes(content)

    with open_bag(path) as bag:
        x = [topic.type.decode(message).x for topic, _, message in bag.messages()]
        (notice,) = bag.notices

    assert x == [float(i) for i in range(50) if i not in lost]
    begin, end = lost[0] / 10, lost[-1] / 10
    assert f'a chunk with a wrong checksum or size, {begin:.1f} to {end:.1f} s, is left' in notice
    with pytest.raises(ReaderError, match='checksum'), AnyReader([path]) as reader:
        list(reader.messages())


def test_flushed_messages_are_readable_while_the_bag_is_open(tmp_path, data):
    with BagWriter(tmp_path / 'bag') as writer:
        topic = add_points(writer)
        for time_ns, message in enumerate(data[:30], start=1):
            writer.write(topic, time_ns, message)
        writer.flush()
        for time_ns, message in enumerate(data[30:], start=31):
            writer.write(topic, time_ns, message)

        assert count(tmp_path / 'bag') == 30
    assert count(tmp_path / 'bag') == 50


def test_a_recorder_that_is_killed_while_it_writes_the_index_has_lost_nothing(
    tmp_path, data, monkeypatch
):
    writer = BagWriter(tmp_path / 'bag')
    monkeypatch.setattr(writer._writer, 'close', lambda: None)
    with writer:
        writer.write(add_points(writer), 1, data[0])

    assert count(tmp_path / 'bag') == 1


def test_a_recorder_that_is_killed_at_once_leaves_a_bag_without_messages(tmp_path):
    with BagWriter(tmp_path / 'bag') as writer:
        add_points(writer)
        with pytest.raises(SetcmasError, match='was cut short: no messages were read'):
            count(tmp_path / 'bag')


def test_a_failing_disk_leaves_what_was_written(tmp_path, data):
    def write_until_full():
        with BagWriter(tmp_path / 'bag') as writer:
            writer.write(add_points(writer), 1, data[0])
            writer.flush()
            raise OSError('full')

    with pytest.raises(OSError, match='full'):
        write_until_full()

    assert count(tmp_path / 'bag') == 1


def test_folders_that_cannot_be_created(tmp_path):
    (tmp_path / 'file').touch()
    with pytest.raises(SetcmasError, match='exists already; it must be a new folder'):
        BagWriter(tmp_path)
    with pytest.raises(SetcmasError, match='cannot be created'):
        BagWriter(tmp_path / 'file' / 'bag')


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


@pytest.fixture
def recorded(tmp_path):
    """Return the transforms by topic that are written for odometry."""

    def recorded(*odometry):
        found = {'/tf': [], '/tf_static': []}
        with BagWriter(tmp_path / 'bag') as writer:
            point = writer.add_topic('/p', POINT, MessageDefinitions().of(POINT), [LATCHED])
            writer.write(point, 1, b'')
            recorder = TransformRecorder(writer)
            for data in odometry:
                recorder.take(data)
            recorder.write()
        with open_bag(tmp_path / 'bag') as bag:
            for topic, _, data in bag.messages():
                if topic.name in found:
                    assert topic.derived
                    found[topic.name].append(topic.type.decode(data).transforms)
        return found

    return recorded


@pytest.mark.parametrize(
    'children', [('tb3_1/base_footprint', 'tb3_10/base_footprint'), 'abcdefgh']
)
def test_transforms_have_the_poses_of_the_odometry(recorded, children):
    (transforms,) = recorded(*map(odometry, children))['/tf']

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
def test_odometry_without_a_pose_in_the_world_makes_no_transform(recorded, data):
    assert recorded(data) == {'/tf': [], '/tf_static': []}


def test_base_link_is_above_the_base_footprint(recorded):
    ((link,),) = recorded(odometry('tb3_3/base_footprint'), odometry('tb3_4'))['/tf_static']

    assert (link.header.frame_id, link.child_frame_id) == (
        'tb3_3/base_footprint',
        'tb3_3/base_link',
    )
    assert (link.transform.translation.z, link.transform.rotation.w) == (0.01, 1.0)
