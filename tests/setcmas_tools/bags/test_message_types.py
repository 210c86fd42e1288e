import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from setcmas_tools.bags.message_types import (
    MessageDefinitions,
    UnknownDefinitionError,
)


def install(prefix, files):
    for msgtype, text in files.items():
        path = prefix / 'share' / f'{msgtype}.msg'
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return [prefix / 'empty', prefix]


def test_built_in_definition_with_its_parts():
    store = MessageDefinitions([]).store

    text, _ = store.generate_msgdef('nav_msgs/msg/Odometry', ros_version=2)
    types = get_types_from_msg(text, 'nav_msgs/msg/Odometry')
    assert {'geometry_msgs/msg/Quaternion', 'std_msgs/msg/Header'} < set(types)
    # The hash that ros2 topic info --verbose shows on Jazzy.
    assert store.hash_rihs01('nav_msgs/msg/Odometry') == (
        'RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0'
    )


def test_installed_definitions_and_what_they_are_made_of(tmp_path):
    prefixes = install(
        tmp_path,
        {
            'lab_msgs/msg/Probe': 'uint8 GOOD=1\nlab_msgs/Sensor[] sensors\nstd_msgs/Header head',
            'lab_msgs/msg/Sensor': 'float64 value  # in V\nSensorKind kind',
            'lab_msgs/msg/SensorKind': 'uint8 kind',
        },
    )
    found = MessageDefinitions(prefixes)
    found.add('lab_msgs/msg/Probe')

    text, _ = found.store.generate_msgdef('lab_msgs/msg/Probe', ros_version=2)
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(text, 'lab_msgs/msg/Probe'))
    assert store.hash_rihs01('lab_msgs/msg/Probe') == found.store.hash_rihs01('lab_msgs/msg/Probe')
    assert store.types['lab_msgs/msg/Probe'].GOOD == 1
    assert 'lab_msgs/msg/SensorKind' in store.types


@pytest.mark.parametrize(
    'text', [None, 'lab_msgs/Missing part', 'float64 $ value', 'float64 x\nfloat64 x']
)
def test_unknown_and_malformed_definitions(tmp_path, text):
    prefixes = install(tmp_path, {'lab_msgs/msg/Probe': text} if text else {})

    with pytest.raises(UnknownDefinitionError, match=r'is installed|malformed'):
        MessageDefinitions(prefixes).add('lab_msgs/msg/Probe')
