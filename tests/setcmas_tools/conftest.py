"""Messages, and bags written by rosbags, for the tests of the tools."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from circling_fleets import circling_fleet
from recordings import RECORDER
from rosbags.interfaces import Nodetype
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from setcmas_tools.run.run_tables import RunTables, write_tables

START_NS = 1_700_000_000_123_456_789

Messages = Sequence[tuple[str, float, Any]]
"""Topic, time in s from START_NS, and the message."""

LAB_DEFINITION = """
string name
float64[] values
lab_msgs/Sample[] samples
================================================================================
MSG: lab_msgs/Sample
builtin_interfaces/Time stamp
int32[2] counts
string[] labels
"""


@pytest.fixture(scope='session')
def store() -> Typestore:
    """The types of Jazzy, and one that no ROS distribution has."""
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg(LAB_DEFINITION, 'lab_msgs/msg/Reading'))
    return store


@pytest.fixture(scope='session')
def make(store: Typestore) -> Callable[..., Any]:
    """A function that makes a message of zeros, with fields set by their dotted names."""

    def make(msgtype: str, fields: dict[str, Any] | None = None) -> Any:
        message = _zero(store, msgtype)
        for name, value in (fields or {}).items():
            *parents, last = name.split('.')
            owner = message
            for parent in parents:
                owner = getattr(owner, parent)
            setattr(owner, last, value)
        return message

    return make


@pytest.fixture
def write_bag(store: Typestore) -> Callable[..., Path]:
    """A function that writes a rosbag2 bag with a chunk for each second."""

    def write_bag(path: Path, messages: Messages, plugin: str = 'mcap') -> Path:
        with Writer(path, version=9, storage_plugin=StoragePlugin[plugin.upper()]) as writer:
            second = 0
            for seconds, *entry in _entries(writer, store, store.serialize_cdr, messages):
                if plugin == 'mcap' and int(seconds) > second:
                    writer.storage.close_chunk()
                    second = int(seconds)
                writer.write(*entry)
        return path

    return write_bag


@pytest.fixture
def write_ros1_bag(store: Typestore) -> Callable[..., Path]:
    """A function that writes a ROS 1 bag."""

    def write_ros1_bag(path: Path, messages: Messages) -> Path:
        ros1_store = get_typestore(Stores.ROS1_NOETIC)
        ros1_store.register(get_types_from_msg(LAB_DEFINITION, 'lab_msgs/msg/Reading'))
        with Ros1Writer(path) as writer:
            for _, *entry in _entries(writer, ros1_store, ros1_store.serialize_ros1, messages):
                writer.write(*entry)
        return path

    return write_ros1_bag


def _entries(writer: Any, store: Typestore, serialize: Any, messages: Messages) -> Iterator[Any]:
    """Yield the time in s, the connection, the time in ns and the bytes of each message."""
    connections: dict[tuple[str, str], Any] = {}
    for topic, seconds, message in messages:
        msgtype = message.__msgtype__
        if (topic, msgtype) not in connections:
            connections[topic, msgtype] = writer.add_connection(topic, msgtype, typestore=store)
        time_ns = START_NS + round(seconds * 1e9)
        yield seconds, connections[topic, msgtype], time_ns, serialize(message, msgtype)


@pytest.fixture
def points(make: Callable[..., Any]) -> Messages:
    """200 messages of one topic at 40 Hz, with x = 0, 1, 2, ..."""
    return [
        ('/tb3_1/cmd_cart_vel', i / 40, make('geometry_msgs/msg/Point32', {'x': float(i)}))
        for i in range(200)
    ]


@pytest.fixture
def bag(tmp_path):
    return tmp_path / 'bag'


@pytest.fixture
def record(start, peer, bag):
    """A function that starts a recorder and waits until its bag exists."""

    def record(*arguments, **options):
        recorder = start(*RECORDER, '-o', str(bag), *arguments, **options)
        peer.wait_for(lambda: bag.exists())
        return recorder

    return record


@pytest.fixture
def run(tmp_path):
    """A function that makes the folder of a run with a fleet of a size."""

    def run(nb_robots):
        (tmp_path / 'csv').mkdir(exist_ok=True)
        write_tables(RunTables(circling_fleet(nb_robots)), tmp_path / 'csv')
        return tmp_path

    return run


def _zero(store: Typestore, msgtype: str) -> Any:
    fields = store.fielddefs[msgtype][1]
    return store.types[msgtype](*(_zero_field(store, *desc) for _, desc in fields))


def _zero_field(store: Typestore, kind: Nodetype, detail: Any) -> Any:
    if kind == Nodetype.NAME:
        return _zero(store, detail)
    if kind == Nodetype.BASE:
        return {'string': '', 'bool': False, 'float32': 0.0, 'float64': 0.0}.get(detail[0], 0)
    (element_kind, element), length = detail
    length = length if kind == Nodetype.ARRAY else 0
    if element_kind == Nodetype.BASE and element[0] != 'string':
        return np.zeros(length, {'bool': 'bool', 'byte': 'uint8'}.get(element[0], element[0]))
    return [_zero_field(store, element_kind, element) for _ in range(length)]
