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
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from setcmas_simu.errors import SetcmasError
from setcmas_tools.bags.bag_reader import open_bag
from setcmas_tools.bags.bag_writer import BagWriter, UnknownDefinitionError, add_definition

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
    return writer.add_topic('/points', POINT, get_typestore(Stores.ROS2_JAZZY), [LATCHED])


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
    monkeypatch.setattr(writer, 'close', lambda: None)
    with writer:
        writer.write(add_points(writer), 1, data[0])

    assert count(tmp_path / 'bag') == 1


def test_a_recorder_that_is_killed_at_once_leaves_a_bag_without_messages(tmp_path):
    with BagWriter(tmp_path / 'bag') as writer:
        add_points(writer)
        with pytest.raises(SetcmasError, match='is cut short or damaged: no messages were read'):
            count(tmp_path / 'bag')


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Install .msg files in a sourced workspace."""
    monkeypatch.setenv('AMENT_PREFIX_PATH', f'{tmp_path / "empty"}:{tmp_path}')

    def install(files):
        for msgtype, text in files.items():
            path = tmp_path / 'share' / f'{msgtype}.msg'
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)

    return install


def test_installed_definitions_and_what_they_are_made_of(install):
    install(
        {
            'lab_msgs/msg/Probe': 'uint8 GOOD=1\nlab_msgs/Sensor[] sensors\nstd_msgs/Header head',
            'lab_msgs/msg/Sensor': 'float64 value  # in V\nSensorKind kind',
            'lab_msgs/msg/SensorKind': 'uint8 kind',
        }
    )
    found = get_typestore(Stores.ROS2_JAZZY)
    add_definition('lab_msgs/msg/Probe', found)

    text, _ = found.generate_msgdef('lab_msgs/msg/Probe', ros_version=2)
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(text, 'lab_msgs/msg/Probe'))
    assert store.hash_rihs01('lab_msgs/msg/Probe') == found.hash_rihs01('lab_msgs/msg/Probe')
    assert store.types['lab_msgs/msg/Probe'].GOOD == 1
    assert 'lab_msgs/msg/SensorKind' in store.types


@pytest.mark.parametrize(
    'text', [None, 'lab_msgs/Missing part', 'float64 $ value', 'float64 x\nfloat64 x']
)
def test_unknown_and_malformed_definitions(install, text):
    install({'lab_msgs/msg/Probe': text} if text else {})

    with pytest.raises(UnknownDefinitionError, match=r'is installed|malformed'):
        add_definition('lab_msgs/msg/Probe', get_typestore(Stores.ROS2_JAZZY))
